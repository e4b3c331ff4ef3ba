"""The two ways to find neighbours: the scan grid, and voxels where there is none."""
