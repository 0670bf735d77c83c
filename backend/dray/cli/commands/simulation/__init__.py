"""Commands about a simulated factory, the only ones that import `dray_sim`."""
