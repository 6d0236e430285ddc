"""The stop guard: a small process that stops every axis when the engine cannot, and how to ask it to."""
