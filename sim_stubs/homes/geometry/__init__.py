"""Solids, houses and the floor that they leave free."""
