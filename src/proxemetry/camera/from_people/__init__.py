"""What the people in a photo tell of its focal length (self-calibration)."""
