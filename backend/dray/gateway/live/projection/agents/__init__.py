"""What is known of agents: vehicles, machines and stations, their silence, and what is held against them."""
