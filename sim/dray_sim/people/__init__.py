"""People of a simulated run: operators with their hands, customers who order and cancel, and people who act at random."""
