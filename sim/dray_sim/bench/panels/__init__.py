"""What the panels cost: projection, map, painting, and a crowd of browsers."""
