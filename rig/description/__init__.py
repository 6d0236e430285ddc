"""`rig.toml` to frozen values; every mistake named by file, line and key."""
