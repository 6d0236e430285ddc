"""What is watched beside the dwells: disk, clock, devices, the process, the safe state."""
