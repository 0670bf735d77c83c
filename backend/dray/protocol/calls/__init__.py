"""Calls for help: which operators on duty are asked, in which order, and which one comes. Knows no agent."""
