"""Values that journal, engine, solution and report share; the states of a run."""
