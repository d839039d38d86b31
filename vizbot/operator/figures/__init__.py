"""Figures of a run: pictures of images, maps and likeness, the track, the rate of steps."""
