"""Procedural furniture, and the solids and materials it is made of."""
