"""An agent's data on its own computer: its journal in SQLite, and the count of its lives."""
