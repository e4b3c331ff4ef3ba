"""Series: leaves carried from one scan to many, measured into a table."""
