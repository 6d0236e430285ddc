"""Pages for a browser: a run, the night, the archive; who may, steers there by the requests of the commands."""
