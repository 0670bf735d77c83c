"""The golden transcript of a planned takeover."""

from __future__ import annotations

import sys
from pathlib import Path

from makings import making

from dray.messages import Award, Confirmed, Reason, Role
from dray.messages.fact import CarrierChanged, PrimarySuspected, TaskClosed

sys.path.insert(0, str(Path(__file__).parent))
from stage import Stage, rewritten, without_shafts

GOLDEN = Path(__file__).parent / "planned_takeover.txt"


def play() -> Stage:
    stage = without_shafts(ATV1="p4", ATV2="p3", ATV3="p7")
    goal = making("gear-unit-g2", 24, "O1", plant=stage.plant)
    stage.say("STRAT", "M8", Award("G8", 1, Role.PRIMARY, goal, deadline_s=3600.0), at_s=10.0)
    stage.say("STRAT", "M8", Confirmed(task="G8", epoch=1), at_s=10.02)
    stage.ask_to_leave("ATV2", at_s=20.0)
    stage.ask_to_leave("ATV1", at_s=60.0)
    stage.run(until_s=110.0)
    return stage


def test_a_planned_takeover_is_played_message_by_message() -> None:
    """Compare with the golden file; its prose says what it proves. Rewrite it by running this file."""
    assert rewritten(GOLDEN, play()) == GOLDEN.read_text(encoding="utf-8")


def test_the_history_tells_why_the_carrier_changed_and_of_no_suspicion() -> None:
    facts = [fact for agent, fact in play().facts if agent == "M8"]
    [changed] = [fact for fact in facts if isinstance(fact, CarrierChanged)]
    assert (changed.replaced, changed.epoch, changed.reason) == ("ATV2", 2, Reason.GRACEFUL_SHUTDOWN)
    assert not [fact for fact in facts if isinstance(fact, PrimarySuspected)]
    [closed] = [fact for fact in facts if isinstance(fact, TaskClosed)]
    assert (closed.task, closed.carrier, closed.outcome) == ("M8-1", "ATV1", "delivered")


if __name__ == "__main__":
    GOLDEN.write_text(rewritten(GOLDEN, play()), encoding="utf-8")
