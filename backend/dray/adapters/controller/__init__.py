"""The body of a station or of the delivery gate: a PLC or small computer at the dock, behind a broker."""
