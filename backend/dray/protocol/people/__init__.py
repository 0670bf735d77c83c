"""Common code of agents that people command: authorisation, answers, and the wait for the end of a problem."""
