"""Parts of the calibration panel: the profile in use, making one, laser power, error budget."""
