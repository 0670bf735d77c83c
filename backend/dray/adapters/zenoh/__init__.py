"""The bus of a plant on Zenoh: links and who is let in, the bus itself, who is alive on it, and a vehicle's modem."""
