"""All tests of one sensor axis: made, and decided over all of them."""
