"""One output by itself, from its solution to its findings."""
