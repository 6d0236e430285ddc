"""One file a sensor model, with its names, units, prediction and Jacobian."""
