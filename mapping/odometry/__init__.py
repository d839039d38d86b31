"""Motion between two frames, from images, wheels and gyroscope."""
