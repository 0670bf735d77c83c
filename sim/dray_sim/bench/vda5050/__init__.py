"""What a driver of a vehicle costs: ten of them at ten states a second each, beside bare MQTT clients."""
