"""How far a table may turn before its cables are wound up, and how far it has turned."""
