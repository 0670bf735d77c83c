"""The bus of a plant on Zenoh: links and access control, the bus itself, liveliness tokens, and a vehicle's modem."""
