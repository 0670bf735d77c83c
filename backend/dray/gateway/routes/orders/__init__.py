"""Orders over REST: single orders, files, and the customers' view."""
