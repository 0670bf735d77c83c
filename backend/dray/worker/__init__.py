"""The asyncio shell of one agent, and its inbox."""
