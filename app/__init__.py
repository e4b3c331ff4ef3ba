"""Leafscope without its window: document, headless services and command line."""

__version__ = "0.1.0"
