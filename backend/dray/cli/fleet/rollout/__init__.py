"""The rollout of another version to a running fleet: one agent at a time, each a canary, with a report of the cost.

`update` goes from agent to agent, one `replacement` after the other. A `listener` hears the fleet's bus, and the `canary_verdict`
follows from the other agents' messages. `order_statistics` and the `history` measure the cost, and the `report` shows it.
"""
