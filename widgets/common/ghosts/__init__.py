"""Parts of the panel of ghost points."""
