"""Figures of a run: pictures of images, maps and similarity, the track, the rate of steps."""
