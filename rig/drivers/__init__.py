"""How the devices and the twins of each driver are opened."""
