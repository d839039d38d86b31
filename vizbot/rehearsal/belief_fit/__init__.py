"""Fits the numbers of the belief to an encoder, by views of simulated homes."""
