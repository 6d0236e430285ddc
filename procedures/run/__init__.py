"""The engine: begin, epochs, steering, resume and the end of a run."""
