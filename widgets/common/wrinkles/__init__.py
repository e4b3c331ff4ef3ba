"""Parts of the panel of wrinkles: what is asked, the pictures of a leaf, the table of all."""
