"""One database and its transactions: SQLite or PostgreSQL, one writer at a time, migrated tables."""
