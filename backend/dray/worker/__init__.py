"""The asyncio shell of one agent, and the inbox of what waits for it."""
