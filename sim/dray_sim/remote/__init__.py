"""Simulated bodies in one process and their agents in others: the floor's side of `dray.adapters.remote_body`.

    count_pieces  -- query {plant}/floor/@pieces -> all pieces that are there now

A floor that begins anew knows nothing of the one before. It says nothing to an agent of the earlier floor, so that
the agent finds its body lost. To that agent's next life it says that the body is new.

`server` lets agents elsewhere use the bodies of a floor, `floor_monitor` sees whether two vehicles are in one spot,
`pieces` counts the pieces of a floor elsewhere.
"""

from __future__ import annotations

from dray_sim.remote.floor_monitor import FloorMonitor
from dray_sim.remote.pieces import count_pieces
from dray_sim.remote.server import FloorServer

__all__ = ["FloorMonitor", "FloorServer", "count_pieces"]
