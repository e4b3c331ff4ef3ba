"""``leafscope bench stability``: what must not change an angle, and what it does change."""
