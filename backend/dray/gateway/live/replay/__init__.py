"""Replay: what panels showed, kept, and shown again.

`recorder` keeps the frames of the stream, as a panel of the whole plant gets them, in pieces that begin with a snapshot now and then; `spells` keeps
what every agent did. `film` makes the picture of a moment from these pieces, and `reader` finds them in SQL. The picture goes through
the same visibility as the live one.
"""
