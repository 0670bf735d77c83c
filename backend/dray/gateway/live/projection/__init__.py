"""The projection: turns heartbeats and events into what panels see. Pure: no clock, no I/O.

Folding a message costs only the change it makes. Heartbeats are kept as they came and become views when a
frame is made: ten heartbeats of a vehicle between two frames cost one view. Changes since the last frame are
remembered by id.

`agents` keeps vehicles, machines and stations, and judges which are lost. `orders`, `news`, `closures`,
`recent_commands` and `injected_faults` keep one kind of entity each. `auctions` keeps tasks, `right_of_way`
who waits for whom, `alerting` what is wrong, and `figures` the sums. `dray.gateway.live.visibility` filters
all this for people limited to areas.
"""

from __future__ import annotations

from dray.gateway.live.projection.projection import Projection

__all__ = ["Projection"]
