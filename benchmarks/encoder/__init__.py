"""How well an encoder tells things apart: patches whose contents are known, asked by name."""
