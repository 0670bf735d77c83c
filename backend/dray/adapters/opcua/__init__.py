"""Machines whose controllers are OPC UA servers. Needs the extra `opcua`."""
