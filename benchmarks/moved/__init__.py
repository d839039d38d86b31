"""Homes that change between two visits: what a map forgets, and what it keeps."""
