"""Changes in mid-run: searched for, told from drifts, proved by visits, said, and taken out of each output."""
