"""The projection: makes of heartbeats and events what panels see. Pure: no clock, no I/O.

Folding a message costs the change it makes and nothing else: heartbeats are kept as they came and
become views when a frame is made, so a vehicle that speaks ten times between two frames costs one.
What has changed since the last frame is remembered by id.

`atvs`, `machines`, `tasks`, `orders`, `news`, `alerts`, `given` and `trials` each keep one kind of entity, `factory`
the figures, and `traffic` the passages per lane. Alerts alone are not folded: `troubles` says what is wrong whenever
somebody looks. `scenes` and `sight` make of all that what somebody sees who is limited to areas.
"""

from __future__ import annotations

from dray.gateway.projection.projection import Projection

__all__ = ["Projection"]
