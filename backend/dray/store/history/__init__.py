"""Agents' reports and measurements: events and their gaps, samples, and clock errors."""
