"""A process in service: surroundings, readiness, logs, traces, meters; `gateway` is the one with panels. Nothing here is simulated."""
