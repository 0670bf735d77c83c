"""A real plant's readiness for service: one finding for each requirement (`dray plant ready`)."""
