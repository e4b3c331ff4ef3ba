"""``leafscope bench stability``: what must change neither an angle nor a reflectance."""
