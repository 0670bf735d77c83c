"""The page of a call key: transports to or from one place, and their progress."""
