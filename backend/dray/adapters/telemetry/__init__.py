"""What operators see of a process: metrics for Prometheus, spans for OpenTelemetry, facts in the log."""
