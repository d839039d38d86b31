"""The report of a run: a page with pictures, a map and a video."""
