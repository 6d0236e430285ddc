"""One file a kind of run: its tables, points, refusals, expectations, solution and section of the page."""
