"""Every Qt import of the product."""
