"""Bodies of agents and what is around them: vehicles, workcells, storages, the gate, and the floor that holds them."""
