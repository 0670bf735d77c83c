"""How every agent runs: one step at a time, from an event to effects. Knows no negotiation."""
