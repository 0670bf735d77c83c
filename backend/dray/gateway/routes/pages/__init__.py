"""Pages for browsers: the panels, the login, the customer's page, and the API's documentation."""
