"""`vizbot bench objectnav | multi | retrieval`: searches in simulated homes."""
