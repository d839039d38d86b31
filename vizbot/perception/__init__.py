"""Sensors in, maps out: poses, the obstacle map and the CLIP map."""
