"""Parts of the panel "Series" and of its dialog."""
