"""The focal length from the people in a photo (self-calibration)."""
