"""Which line is opened for which device, who owns it, and lines recorded and replayed."""
