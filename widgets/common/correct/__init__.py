"""Parts of the panel that corrects for the angle of incidence."""
