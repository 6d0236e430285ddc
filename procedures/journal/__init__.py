"""The truth about a run: its journal itself, as it is stored, written, read, verified and salvaged."""
