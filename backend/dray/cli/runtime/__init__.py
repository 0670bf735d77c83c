"""A process in service: what it begins with, serving, readiness, logs, traces, meters. Nothing here is simulated."""
