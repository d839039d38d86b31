"""Finding a robot that was carried away, or that starts in a saved map."""
