"""Pages for a browser: a run, the night, the archive. They read journals and the archive; nothing is steered here."""
