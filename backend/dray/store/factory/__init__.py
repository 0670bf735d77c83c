"""What people decide about a factory, and what it has achieved."""
