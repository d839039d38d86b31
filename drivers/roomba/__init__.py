"""The Roomba base over its serial Open Interface: bytes, odometry, reflexes, modes."""
