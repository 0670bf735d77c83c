"""What agents that people command have in common: whom they obey, what they have answered, and how long a problem is waited for."""
