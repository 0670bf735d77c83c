"""One database and its transactions: SQLite or PostgreSQL, one writer at a time, tables brought up to date."""
