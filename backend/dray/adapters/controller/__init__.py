"""The body of a station or of the delivery gate, for a PLC or small computer at the dock that talks over a broker."""
