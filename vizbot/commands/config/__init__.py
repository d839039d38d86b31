"""`vizbot config`: which settings there are, which are in use, and a file to begin with."""
