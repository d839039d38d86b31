"""Driving from a keyboard in a terminal."""
