"""Routers of the present factory: agents, tasks, places and troubles."""
