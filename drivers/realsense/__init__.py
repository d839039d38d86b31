"""The Intel RealSense D435i through its SDK: discovery, streams, frames, recordings."""
