"""What a person types: one Typer module per command or group. Work is left to the other rooms."""
