"""Orders over REST: one by one, as files, and as the customer is shown them."""
