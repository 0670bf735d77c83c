"""Bodies of agents and their surroundings: vehicles, workcells, storages, the gate, and the floor that holds them."""
