"""The simulated robot in a home: contacts, light, rendering, MJCF, SDF."""
