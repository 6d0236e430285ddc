"""One file a device family: what its commands do, by the abilities that it has; no port."""
