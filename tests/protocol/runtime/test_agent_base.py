"""What all agents have in common."""

from __future__ import annotations

from dray.body import BodyState
from dray.memory import WHOLE, Memory, Note, StrategistMemory
from dray.messages import OrderTaken
from dray.messages.fact import MemoryLost
from dray.protocol.runtime.agent import AgentBase
from dray.protocol.runtime.events import Commit, Record, Send, Started


class Clerk(AgentBase):
    """Counts its lives, and says so before and after it wants to have that written down."""

    def __init__(self, *, diligent: bool = True) -> None:
        super().__init__("clerk", 1, leaves_within_s=1.0)
        self.diligent = diligent
        self.lives = 0

    def _start(self, _body: BodyState | None, memory: Memory, _now_s: float) -> None:
        note = memory.get(WHOLE)
        self.lives = note.goal_count if isinstance(note, StrategistMemory) else 0
        self._life.send("desk", OrderTaken(order="before"))
        if self.diligent:
            self._life.commit()
            self.lives += 1
            self._life.commit()
        self._life.send("desk", OrderTaken(order="after"))

    def _memory(self) -> Note:
        return StrategistMemory(goal_count=self.lives)


def test_who_has_lost_its_memory_says_so_before_all_else() -> None:
    effects = Clerk().handle(Started(None, lost="the disk has failed"), 0.0)
    assert [effect for effect in effects if isinstance(effect, Record)] == [
        Record(MemoryLost("the disk has failed"))
    ]
    assert not any(isinstance(effect, Record) for effect in Clerk().handle(Started(None), 0.0))


def test_what_binds_an_agent_is_written_down_once_and_before_anything_is_said() -> None:
    effects = Clerk().handle(Started(None), 0.0)

    assert effects[0] == Commit(StrategistMemory(goal_count=1))
    assert [type(effect) for effect in effects] == [Commit, Send, Send]


def test_a_step_that_binds_nothing_writes_nothing() -> None:
    clerk = Clerk(diligent=False)

    assert not any(isinstance(effect, Commit) for effect in clerk.handle(Started(None), 0.0))


def test_a_life_goes_on_from_what_the_last_one_has_committed() -> None:
    effects = Clerk().handle(Started(None, {WHOLE: StrategistMemory(goal_count=7)}), 0.0)

    assert effects[0] == Commit(StrategistMemory(goal_count=8))


def test_what_was_written_once_is_not_written_again_at_the_next_step() -> None:
    clerk = Clerk()
    clerk.handle(Started(None), 0.0)
    clerk.diligent = False

    assert not any(isinstance(effect, Commit) for effect in clerk.handle(Started(None), 1.0))
