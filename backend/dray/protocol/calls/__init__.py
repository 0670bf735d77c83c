"""Calls for help: who on duty is asked, in which order, and who comes. Knows no agent: whoever needs help uses it."""
