"""Areas of leaves and their segmentation, against the truth and against simple alternatives."""
