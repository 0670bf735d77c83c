"""People's decisions about a factory, and its achievements."""
