"""Who is told when a run stops, and by which channel."""
