"""What the phase-function lab does without a window: fits, comparisons, tables, figures."""
