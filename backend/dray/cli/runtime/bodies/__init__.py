"""Creating the bodies of agents in their processes: one module for each kind."""
