"""Wrinkles of the leaves of a scan: calibrated, measured, tabulated and drawn."""
