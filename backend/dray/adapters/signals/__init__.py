"""A machine with single-value signals of a controller: their meaning, and the handling of contradictions."""
