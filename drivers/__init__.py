"""Drivers of the real devices: the Roomba base and the RealSense camera."""
