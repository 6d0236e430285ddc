"""The page on paper: the very HTML page, set as PDF/A-3b by typst, with the machine-readable results attached."""
