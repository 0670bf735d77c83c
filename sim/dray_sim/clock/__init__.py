"""Virtual time: a clock that jumps, the asyncio loop on it, and the clock of each agent's computer."""
