"""Parts of the panel about indices."""
