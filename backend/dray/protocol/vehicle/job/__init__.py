"""The transport that a vehicle carries: its states, what is next, what is done then and what is said."""
