"""What the outputs of a package, or all packages on a table, show together: table, base, meter, mount."""
