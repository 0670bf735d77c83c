"""What is known of agents: vehicles, machines, stations, their silence, and disputes about them."""
