"""A machine without a controller: people operate it and report the events."""
