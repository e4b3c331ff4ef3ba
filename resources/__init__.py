"""Icons, palettes, presets and the guide: files that any layer may read."""
