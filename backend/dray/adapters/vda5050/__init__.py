"""Vehicles that speak VDA 5050 over MQTT, as the port `dray.ports.Body`: each agent is the master of its own vehicle alone.

    agent <-> VehicleBody <-> MasterControl (pure: handle(event, now_s) -> effects) <-> MqttLink <-> broker <-> vehicle

`control` decides on orders, refusals, position, load and problems (`undriven_orders`: orders that end before the vehicle drives;
`reported_node`: whether it can have reached the node that it reports). `wire` reads and writes messages, by one table of dialects.
`profile` is the file about one vehicle type's abilities. `body` is the port, `link` the asyncio shell on a broker.
docs/vehicles.md explains the commissioning of a vehicle.
"""
