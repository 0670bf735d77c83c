"""What a browser shows: the panels, the login, the customer's page, and the API's documentation."""
