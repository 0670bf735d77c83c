"""Replay: what panels showed, stored and shown again.

`recorder` stores the stream's frames for the whole plant, in pieces that now and then begin with a snapshot;
`spells` stores what every agent did. `film` rebuilds a past moment from these pieces, and `reader` finds them
in SQL. The picture passes the same visibility as the live one.
"""
