"""What rows say against the sensors that made them: an output that is wrong, hangs or stands, and what is unseen."""
