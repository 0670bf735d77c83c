"""Who may come in, and who did what: people, sessions, keys, lock-outs, the audit log."""
