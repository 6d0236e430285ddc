"""The lease of devices that more than one computer reaches: taken in the archive, kept while a rig is open."""
