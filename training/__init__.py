"""The program that trains the embedded CLIP; no run of the robot needs it."""
