"""`vizbot calibrate`: a short drive that finds wheel scale, heading and mount."""
