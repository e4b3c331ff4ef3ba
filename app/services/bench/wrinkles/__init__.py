"""``leafscope bench wrinkles``: angles from intensity against the truth."""
