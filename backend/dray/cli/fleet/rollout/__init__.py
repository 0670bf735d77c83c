"""A running fleet gets another version: one agent at a time, each a canary, with a report of what it cost."""
