"""What agents have told and measured: events and their gaps, samples, and what their clocks make of it."""
