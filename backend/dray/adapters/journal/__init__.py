"""What an agent keeps on its own computer: its journal in SQLite, and the count of its lives."""
