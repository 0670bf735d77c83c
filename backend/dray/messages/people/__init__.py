"""Messages between people and agents: duty, calls for help, and commands."""
