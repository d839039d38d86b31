"""What a robot must know about itself: wheels, and where its camera sits."""
