"""``leafscope bench incidence``: how right and how fast the angles of incidence are."""
