"""Dray runs the material flow of a factory with no dispatcher."""

__version__ = "0.1.0"
