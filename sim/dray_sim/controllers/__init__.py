"""The controllers of simulated machines, as PLCs in the field are, and an OPC UA server that has them all. The server needs the extra `opcua`."""
