"""Who is who, and who may do what.

`principal` is somebody who has been recognised, `rules` the table of what each route asks of its caller.
`gate` stands before all routes and lets nobody pass whom the table does not; `caller` gives a router the
one who asks. `sessions`, `keys` and `login` recognise people and systems; `audit_log` keeps what they did.
Operators see and command their own areas only (paper, 3.2).
"""
