"""What has happened, from SQL: the agents' events, promises, figures over time, the audit log."""
