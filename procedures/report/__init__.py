"""The page of a run: what it shows, its figures and its text."""
