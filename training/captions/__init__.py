"""Captions of pictures of simulated homes, for training."""
