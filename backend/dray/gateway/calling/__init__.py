"""The page of a call key: what is to be brought to one place, or taken away from it, and how far that is."""
