"""Bodies of agents, as their processes make them: one module for each kind."""
