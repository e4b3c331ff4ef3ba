"""Benches: tables of measured numbers, with pictures, that anyone can make again."""
