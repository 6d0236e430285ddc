"""Gyros: their rates, alone or beside accelerometers and magnetometers, integrated or filtered."""
