"""The projection: makes of heartbeats and events what panels see. Pure: no clock, no I/O.

Folding a message costs the change it makes and nothing else: heartbeats are kept as they came and
become views when a frame is made, so a vehicle that speaks ten times between two frames costs one.
What has changed since the last frame is remembered by id.

`agents` keeps vehicles, machines and stations, and judges who is lost; `orders`, `news`, `closures`, `recent_commands` and
`injected_faults` keep one kind of entity each; `auctions` keeps tasks, `right_of_way` who waits for whom, `alerting` what is wrong, and
`figures` the sums. What of it somebody sees who is limited to areas is said in `dray.gateway.live.visibility`.
"""

from __future__ import annotations

from dray.gateway.live.projection.projection import Projection

__all__ = ["Projection"]
