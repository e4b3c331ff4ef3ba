"""Mouse tools: one file each, all with the same few methods."""
