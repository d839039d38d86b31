"""The CLIP feature map: encoders, the multi-scale mapper and retrieval by words."""
