"""The scan image: a picture of what the scanner saw, for eyes and hands."""
