"""Vehicles that speak VDA 5050 over MQTT, as the port `dray.ports.Body`: each agent is the master of its own vehicle alone.

    agent <-> VehicleBody <-> MasterControl (pure: handle(event, now_s) -> effects) <-> MqttLink <-> broker <-> vehicle

`control` decides: which order is said next, whether the vehicle has taken it, where it is, what is on board, what is a
problem. `wire` reads and writes messages, by one table of dialects. `profile` is what one vehicle type understands, as a
file. `body` is the port, `link` the asyncio shell on a broker. docs/vehicles.md tells how a vehicle is brought in.
"""
