"""Estimators of the local plane at a point, one file each."""
