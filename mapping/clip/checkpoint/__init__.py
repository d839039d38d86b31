"""CLIP models on this machine: where their files are, what they hold, and whether they work."""
