"""The floor as panels see it: what is closed, what lies there, and who waits."""
