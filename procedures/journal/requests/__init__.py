"""What people ask of a run: requests to its engine, and corrections where no process runs it."""
