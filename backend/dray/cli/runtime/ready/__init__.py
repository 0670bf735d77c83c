"""What a real plant still lacks for service: one finding for each thing that must be there (`dray plant ready`)."""
