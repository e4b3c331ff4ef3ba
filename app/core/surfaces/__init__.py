"""A leaf as a surface: its cells on the scan grid, smoothed ranges, its border, its mesh."""
