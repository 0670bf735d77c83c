"""A machine without a controller: people work it, and say what has happened."""
