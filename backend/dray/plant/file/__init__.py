"""The plant file: its text, the shapes in it, and every fault by line and field."""
