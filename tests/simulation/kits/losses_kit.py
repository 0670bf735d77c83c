"""What agents say and do in a run of the benchmark that kills, for tests."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection
from typing import Literal

from makings import making

from dray.errors import UnavailableError
from dray.gateway.live.timescale import TimeScale
from dray.messages import (
    Event,
    MachineHeartbeat,
    MachineStatus,
    Role,
)
from dray.messages.fact import ContractTaken, Fact, TaskClosed
from dray_sim.bench.losses.campaign import Campaign
from dray_sim.bench.losses.history import History
from dray_sim.explore.run import draw
from dray_sim.run.witness import Witness

GOAL = making("pump-p3", 24, "O-1")


class Told:
    """Facts, one second after the other, numbered as agents number them."""

    def __init__(self) -> None:
        self.events: list[Event] = []
        self._numbers: Counter[tuple[str, int]] = Counter()

    def by(self, agent: str, *facts: Fact, life: int = 1) -> None:
        for fact in facts:
            self._numbers[agent, life] += 1
            at_s = 1.0 + len(self.events)
            self.events.append(Event(agent, life, self._numbers[agent, life], at_s, fact))

    @property
    def history(self) -> History:
        history = History()
        history.add(self.events)
        return history


def taken(task: str, role: Role = Role.PRIMARY) -> ContractTaken:
    return ContractTaken(task=task, epoch=1, role=role, coordinator="M8")


def closed(
    task: str, carrier: str = "ATV2", outcome: Literal["delivered", "withdrawn"] = "delivered"
) -> TaskClosed:
    return TaskClosed(task=task, epoch=1, outcome=outcome, carrier=carrier)


def heartbeat(**fields: object) -> MachineHeartbeat:
    return MachineHeartbeat(
        machine="M8", incarnation=1, seq=1, at_s=1000.0, status=MachineStatus.IDLE, **fields
    )


class Ailing:
    """A fleet that cannot be killed, or of which nobody comes back."""

    url, token = "http://127.0.0.1:1", "t"
    time = TimeScale(0.0, 0.0, 1.0)

    def __init__(self, *, ended: bool) -> None:
        self._ended = ended

    def kill(self, name: str) -> bool:
        if self._ended:
            raise UnavailableError("fleet.json", "no such file", "start a fleet")
        return True

    def last_words(self, name: str) -> str:
        return f"the log of {name} ends with: Aargh"


class Deaf:
    """A watch that hears nobody, and sees some come back."""

    def __init__(self, back: Collection[str] = ()) -> None:
        self.heard = Witness()
        self._back = back

    def joined_since(self, agent: str, since_s: float) -> float | None:
        return since_s + 1.0 if agent in self._back else None


SMALL = Campaign(
    # Small containers and short cycles: much is carried in little time.
    plant=draw(24).plant,
    speed=20.0,
    plain=True,
    load=0.8,
    head_start_s=100.0,
    warm_s=0.0,
    quiet_s=15.0,
    each=1,
    lasting=1,
    kills=14,
    pause_s=2.0,
    down=2,
    # Ten minutes of the plant, as its goods are waited for.
    lasting_s=30.0,
    dark_s=2.0,
    drain_s=240.0,
    seed=1,
)
