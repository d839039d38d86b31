"""Where our own furniture is made: one module for each kind, from the same solids and materials."""
