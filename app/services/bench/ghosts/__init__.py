"""Ghost points: how many are found and put back, against the truth and against peers."""
