"""What ``import calrig`` offers to scripts and notebooks; the package of that name lies in import_name."""
