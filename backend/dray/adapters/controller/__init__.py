"""The body of a station, or of the delivery gate, that a controller at the dock has: a PLC or a small computer, behind a broker."""
