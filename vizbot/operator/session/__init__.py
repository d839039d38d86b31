"""What people ask of a running robot: tasks, driving by hand, zones, questions."""
