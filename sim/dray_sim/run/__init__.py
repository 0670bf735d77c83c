"""One seeded run: its stage, its listeners, its report, its evidence and its verdict."""
