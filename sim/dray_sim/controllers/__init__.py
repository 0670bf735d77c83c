"""The controllers of simulated machines, storages and the gate, as PLCs are in the field, and an OPC UA server that has them all. The server needs the extra `opcua`."""
