"""People who do things at random, for the search: buttons, answers, cancelled and revoked orders."""
