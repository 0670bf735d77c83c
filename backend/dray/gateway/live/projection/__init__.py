"""The projection: makes of heartbeats and events what panels see. Pure: no clock, no I/O.

Folding a message costs the change it makes and nothing else: heartbeats are kept as they came and
become views when a frame is made, so a vehicle that speaks ten times between two frames costs one.
What has changed since the last frame is remembered by id.

`atvs`, `machines`, `stations`, `orders`, `news`, `recent_commands` and `injected_faults` each keep one kind of entity;
`auctions` keeps tasks, `alerting` what is wrong, and `figures` the sums. `silence` judges who is lost. What of it
somebody sees who is limited to areas is said in `dray.gateway.live.visibility`.
"""

from __future__ import annotations

from dray.gateway.live.projection.projection import Projection

__all__ = ["Projection"]
