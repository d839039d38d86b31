"""`vizbot bench questions`: does the map of a real recording know where things are?"""
