"""Bodies in one process and their agents in others: the floor of a factory whose agents are processes.

    agent's process                                the floor's process
    Body.instruct --> {plant}/body/@{agent}/do --> Body.instruct
    Body.attach  <-- {plant}/body/@{agent}/told <-- reports, and the state after them, ten times a second
    Body.sense   is the state that was told last
    put_down      -- query {plant}/floor/@newcomers: a body that the plant file does not know
    count_pieces  -- query {plant}/floor/@pieces -> all pieces that are there now
    connect       -- query {plant}/body/@{agent} -> the state now; from then on this life's word counts

A real vehicle has its body on its own computer, and wires lose nothing. The bus may: who passes on what others
say may be killed. So instructions and reports are said until they are heard (`Exchange`), and whichever side has
too much to say lets go of the other: no part is left out, and the next life begins with the state of the body. A
killed agent leaves its body behind as hardware is left behind: a loaded vehicle stays loaded, and drives its way
to the end.

What comes in crosses to the loop by a bounded queue (`Crossing`). A letter that finds no room there is said again; a
question is refused.

A floor that begins anew knows nothing of the one before. To an agent that has taken over its body there, it
says nothing, so that the agent finds its body lost; and to the next life it says that the body is new.

There is no seal on these keys: whoever is on the bus may move simulated bodies.

`body` is the agent's side and `server` the floor's, `wire` is what goes between them; `questions` asks and answers, and
`exchange` sees to it that what is said is heard.
"""

from __future__ import annotations

from dray_sim.remote.body import RemoteBody
from dray_sim.remote.questions import count_pieces, put_down
from dray_sim.remote.server import FloorServer
from dray_sim.remote.wire import Newcomer

__all__ = ["FloorServer", "Newcomer", "RemoteBody", "count_pieces", "put_down"]
