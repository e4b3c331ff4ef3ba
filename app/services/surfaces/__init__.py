"""Leaves as surfaces: meshes and areas of a scan's leaves, and their files."""
