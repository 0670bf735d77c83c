"""A machine whose controller tells and obeys single values: what they mean, and what is to be done when they contradict one another."""
