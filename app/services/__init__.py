"""Use-cases: the same call serves the window and the command line."""
