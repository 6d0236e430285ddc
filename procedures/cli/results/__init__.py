"""What a run has measured: solve, data, export and verify, and results as lines of text."""
