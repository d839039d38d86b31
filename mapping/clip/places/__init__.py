"""Places of the plan: which views show them, and how probable it is that they are what is asked."""
