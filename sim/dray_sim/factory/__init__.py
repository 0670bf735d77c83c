"""A whole simulated factory: bodies, network and one worker per agent."""
