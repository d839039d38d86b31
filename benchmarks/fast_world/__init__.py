"""A fast world to think in: the search alone, on true poses and on views that are made once."""
