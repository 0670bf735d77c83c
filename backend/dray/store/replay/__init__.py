"""What panels showed, kept so that it can be shown again; and what every vehicle and machine did, spell by spell."""
