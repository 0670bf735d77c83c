"""A gateway in service: its port and who may hold it, its first users and its key, a clean stop, people on duty."""
