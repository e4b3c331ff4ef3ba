"""One file per format, each a reader and, where it has one, a writer."""
