"""Products: what this plant can make."""
