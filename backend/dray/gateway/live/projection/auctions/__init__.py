"""Every auction as panels see it (paper, 4.1): bids, refusals, the carrier, and why it was chosen.

`tasks` folds the facts; `reorder_buffer` keeps facts that arrive before their task is opened.
"""
