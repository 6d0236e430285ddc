"""The archive of sets and runs: SQLAlchemy tables, migrations, signatures and the hash-chained ledger."""
