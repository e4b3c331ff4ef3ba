"""Pictures without Qt: the only place of `app` that loads VTK."""
