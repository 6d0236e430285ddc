"""What a change in mid-run leaves in the rows, or the way that the table came: patterns, scans, likeliest places."""
