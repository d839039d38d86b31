"""Planning and following paths on the obstacle map."""
