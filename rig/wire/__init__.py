"""One codec a protocol: bytes to values and back; no port, no clock and no device."""
