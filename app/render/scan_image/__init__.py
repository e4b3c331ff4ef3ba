"""What the scanner saw, as a picture: azimuth to the right, elevation upwards."""
