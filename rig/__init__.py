"""The hardware and its twins: what is connected, how bytes go, what moves, what is read."""
