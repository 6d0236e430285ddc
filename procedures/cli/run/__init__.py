"""A run from the command line: run and resume, with all that stands around them."""
