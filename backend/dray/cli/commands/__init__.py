"""The commands: one Typer module per command or group. The other rooms do the work."""
