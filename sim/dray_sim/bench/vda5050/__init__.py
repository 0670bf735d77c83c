"""The cost of a vehicle's driver: ten of them at ten states a second each, beside bare MQTT clients."""
