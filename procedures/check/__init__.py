"""What `calrig check` and `calrig design` tell before anything moves."""
