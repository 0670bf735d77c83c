"""The past, from SQL: agents' events, promises, figures over time, the audit log."""
