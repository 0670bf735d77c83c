"""Who callers are, and what they may do.

`principal` is a recognised caller, `rules` the table of what each route requires. `gate` stands before all
routes and refuses callers that the table does not admit; `caller` gives a router its caller. `sessions`,
`keys` and `login` recognise people and systems; `audit_log` records their actions. Operators see and command
only their own areas (paper, 3.2).
"""
