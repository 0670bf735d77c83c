"""A body that is elsewhere on the bus, as its agent uses it: the port `dray.ports.Body` over Zenoh.

    agent's process                                process of the bodies
    Body.instruct --> {plant}/body/@{agent}/do --> Body.instruct
    Body.attach  <-- {plant}/body/@{agent}/told <-- reports, and the state after them, ten times a second
    Body.sense   is the state that was told last
    put_down      -- query {plant}/floor/@joining: a body that the plant file does not know
    tell_moved    -- query {plant}/floor/@moved: a transfer of a vehicle that is not simulated, to be counted
    connect       -- query {plant}/body/@{agent} -> the state now; from then on this life's word counts

A real vehicle has its body on its own computer, and wires lose nothing. The bus may: who passes on what others
say may be killed. So instructions and reports are said until they are heard (`Exchange`), and whichever side has
too much to say lets go of the other: no part is left out, and the next life begins with the state of the body. A
killed agent leaves its body behind as hardware is left behind: a loaded vehicle stays loaded, and drives its way
to the end.

What comes in crosses to the loop by a bounded queue (`Crossing`). A letter that finds no room there is said again; a
question is refused.

There is no seal on these keys: whoever is on the bus may move bodies.

`body` is the agent's side, `counted` that of a vehicle that is not simulated and works at places that are, `wire` is what goes between the two sides; `questions` asks what is answered, and
`exchange` sees to it that what is said is heard. Simulated bodies have their side in `dray_sim.remote`.
"""

from __future__ import annotations

from dray.adapters.remote_body.body import RemoteBody
from dray.adapters.remote_body.counted import CountedBody
from dray.adapters.remote_body.questions import put_down, tell_moved
from dray.adapters.remote_body.wire import BodySpec

__all__ = ["BodySpec", "CountedBody", "RemoteBody", "put_down", "tell_moved"]
