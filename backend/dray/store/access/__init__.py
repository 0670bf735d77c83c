"""Access and accountability: people, sessions, keys, lock-outs, the audit log."""
