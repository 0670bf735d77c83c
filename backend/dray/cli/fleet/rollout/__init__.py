"""A running fleet gets another version: one agent at a time, each a canary, with a report of what it cost.

`update` goes from agent to agent, one `replacement` after the other. A `listener` hears the fleet's bus, and from what
others say there follows the `canary_verdict`. `order_statistics` and the `history` have what it has cost, and the
`report` tells it.
"""
