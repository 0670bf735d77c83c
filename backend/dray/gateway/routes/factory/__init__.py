"""Routers of the factory as it is now: its agents, their tasks, what lies where, and what is wrong."""
