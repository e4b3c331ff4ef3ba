"""Fits of angular models: how fast, how right, and how honest about their doubt."""
