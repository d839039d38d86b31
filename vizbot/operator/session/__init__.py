"""What people ask of a running robot: tasks, driving, zones, questions."""
