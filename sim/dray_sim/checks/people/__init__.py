"""Invariants of people: calls for help, commands by grant, out of service, and goals handed over."""
