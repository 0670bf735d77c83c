"""People who act at random, for the search: buttons, answers, cancelled and revoked orders."""
