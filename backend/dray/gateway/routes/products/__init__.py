"""Products that this plant can make."""
