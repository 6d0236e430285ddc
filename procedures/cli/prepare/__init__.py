"""Before anything moves: demo, new, design, plan, check."""
