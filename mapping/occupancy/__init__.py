"""The 2D obstacle map, made from depth images."""
