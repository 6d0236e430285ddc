"""The calibration certificate: what ISO/IEC 17025 clause 7.8 asks, from an approved set and nothing else."""
