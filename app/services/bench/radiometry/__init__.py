"""Benches of the calibration from number to reflectance."""
