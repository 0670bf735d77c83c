"""Every auction as panels see it (paper, 4.1): its bids and refusals, who carries the task, and why that one.

`tasks` folds the facts; `reorder_buffer` keeps those that were heard before their task was opened.
"""
