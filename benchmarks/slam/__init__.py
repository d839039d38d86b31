"""`vizbot bench slam`: pose estimation in recordings and simulated homes."""
