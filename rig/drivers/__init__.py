"""What a driver is, and one file a driver that brings its codec, device and twin together."""
