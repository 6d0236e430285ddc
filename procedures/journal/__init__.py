"""The truth about a run: its writer, readers, header, salvage and the requests to a running engine."""
