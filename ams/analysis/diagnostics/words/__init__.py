"""What the tests say to people: sentences for what was found, and whether the stated uncertainties hold it."""
