"""The cost of the panels: projection, map, painting, and a crowd of browsers."""
