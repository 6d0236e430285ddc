"""All sensors of a run together, visit by visit: the same judgement while the run goes on and in its report."""
