"""One seeded run: the stage, who watches it, and what its report, its evidence and its verdict are."""
