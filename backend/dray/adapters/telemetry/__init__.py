"""A process's telemetry for operators: metrics for Prometheus, spans for OpenTelemetry, facts in the log."""
