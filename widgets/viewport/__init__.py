"""The picture of the scans, and the mouse tools that work in it."""
