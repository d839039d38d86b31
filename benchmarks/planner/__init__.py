"""`vizbot bench planner`: how fast is a path planned, beside other planners by the same rules?"""
