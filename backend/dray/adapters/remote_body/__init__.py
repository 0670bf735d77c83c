"""A body elsewhere on the bus, from its agent's side: the port `dray.ports.Body` over Zenoh.

    agent's process                                process of the bodies
    Body.instruct --> {plant}/body/@{agent}/do --> Body.instruct
    Body.attach  <-- {plant}/body/@{agent}/told <-- reports, and the state after them, ten times a second
    Body.sense   is the last received state
    put_down      -- query {plant}/floor/@joining: a body that the plant file lacks
    tell_moved    -- query {plant}/floor/@moved: a transfer of a vehicle that is not simulated, to be counted
    connect       -- query {plant}/body/@{agent} -> the state now; from then on only this life is obeyed

A real vehicle has its body on its own computer, and wires lose nothing. The bus may lose messages, because a relaying process may be
killed. So instructions and reports are repeated until they are confirmed (`Exchange`). A side with too many unconfirmed parts gives up
the connection: no part is skipped, and the next life begins with the state of the body. A killed agent leaves its body as hardware is
left: a loaded vehicle stays loaded, and drives its way to the end.

Incoming messages cross to the loop by a bounded queue (`Crossing`). A letter without room there is repeated; a question
is refused.

These keys have no seal: any participant of the bus may move bodies.

`body` is the agent's side. `counted` is the side of a vehicle that is not simulated at places that are. `wire` defines the messages,
`questions` asks questions, and `exchange` confirms and repeats. Simulated bodies have their side in `dray_sim.remote`.
"""

from __future__ import annotations

from dray.adapters.remote_body.body import RemoteBody
from dray.adapters.remote_body.counted import CountedBody
from dray.adapters.remote_body.questions import put_down, tell_moved
from dray.adapters.remote_body.wire import BodySpec

__all__ = ["BodySpec", "CountedBody", "RemoteBody", "put_down", "tell_moved"]
