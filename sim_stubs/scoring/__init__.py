"""The scorer: goals of a home, and whether the robot reached one."""
