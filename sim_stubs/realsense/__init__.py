"""A simulated D435i: images, inertial samples, and their errors."""
