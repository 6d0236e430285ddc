"""The bench by hand: the thread that owns the devices, the guard that stops past it, the screen."""
