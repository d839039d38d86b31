"""The rerun viewer: recordings of a run, live or kept."""
