"""Who is who, and who may do what.

`principal` is somebody who has been recognised, `rules` the table of what each route asks of its caller.
`gate` stands before all routes and lets nobody pass whom the table does not; `caller` gives a router the
one who asks.
"""
