"""The transport that a vehicle carries: its states, its moves and its messages."""
