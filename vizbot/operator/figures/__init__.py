"""Pictures of images, maps and similarity, as arrays."""
