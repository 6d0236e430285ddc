"""A run for other people's software: its journal as tables, written in the formats that they read."""
