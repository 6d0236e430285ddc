"""Where a run stands: read by any process at any time, for the terminal, pages and monitoring, and what to do next."""
