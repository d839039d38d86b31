"""What the robot does with its wheels besides searching: safety, docking, steps."""
