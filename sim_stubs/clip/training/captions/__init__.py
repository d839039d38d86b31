"""What a picture of a simulated home shows, put into words for training."""
