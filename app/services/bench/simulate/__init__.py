"""The virtual scanner: is it right, what does it cost, does another simulator agree."""
