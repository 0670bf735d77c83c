"""A machine's agent that is started again, for tests."""

from __future__ import annotations

from effects import committed
from rigs import BlindRig, MachineRig

from dray.body import OpenDock
from dray.memory import Memory


def next_life(
    before: MachineRig,
    *,
    opened: tuple[str, ...] = (),
    let_in: OpenDock | None = None,
    memory: Memory | None = None,
) -> MachineRig:
    """The next life of an agent whose body does not count; that goes on, and its dock is as it was.

    Args:
        before: the life before.
        opened: vehicles for which the body opens its dock still, if that takes time.
        let_in: what it remembers of the last of them.
        memory: the agent's notes; those of the life before unless given.
    """
    agent = before.agent
    rig = BlindRig(agent.id, before.stock, plant=agent._plant, incarnation=agent.incarnation + 1)
    rig.memory = (committed(before.all) or before.memory) if memory is None else memory
    rig.answers, rig.opened, rig.let_in = before.answers, opened, let_in
    rig.now_s, rig.seq = before.now_s, before.seq
    rig.start()
    return rig
