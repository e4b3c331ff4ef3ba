"""Planes of whole leaves: how right their angles are."""
