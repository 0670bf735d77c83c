"""A gateway in service: its port and connection limits, its first users and its key, a clean end, people on duty."""
