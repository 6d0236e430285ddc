"""`procedure.toml` to frozen values."""
