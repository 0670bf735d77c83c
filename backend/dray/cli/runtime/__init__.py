"""A process in service: what it begins with, readiness, logs, traces, meters; `gateway` is the one with panels. Nothing here is simulated."""
