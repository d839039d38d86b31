"""What people say and type: one grammar for every way in, and the one place that obeys it."""
