"""The parts of the phase lab: choices, plot, brush, pages."""
