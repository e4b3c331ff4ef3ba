"""Dialogs: opened, never executed; each says what it will do before it does it."""
