"""The panels around the picture; none knows another."""
