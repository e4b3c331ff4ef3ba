"""Angles from intensity in full: curves, offsets, validity, errors, wrinkles of a leaf."""
