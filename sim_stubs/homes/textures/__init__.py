"""Pictures on the surfaces of a home."""
