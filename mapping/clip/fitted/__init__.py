"""Numbers of the belief that were fitted to one encoder, and encoders that have them."""
