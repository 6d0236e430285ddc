"""What is done: plans, the run engine and its journal, solutions, reports, and the command."""
