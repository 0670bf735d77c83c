"""The golden transcript of the paper's Figure 3."""

from __future__ import annotations

import sys
from pathlib import Path

from makings import making

from dray.messages import Award, Confirmed, Production, Role, Transport
from dray.messages.fact import AwardAnswered, AwardGiven, BidReceived

sys.path.insert(0, str(Path(__file__).parent))
from stage import Stage, rewritten, without_shafts

GOLDEN = Path(__file__).parent / "figure_3.txt"


def play() -> Stage:
    stage = without_shafts(ATV1="p4", ATV2="p3", ATV3="p1")
    # The strategist's goal makes M8 look at its shafts; M7 elects ATV3 while M8 still collects bids.
    goal = making("gear-unit-g2", 24, "O1", plant=stage.plant)
    stage.say("STRAT", "M8", _award("G8", goal), at_s=10.0)
    stage.say("STRAT", "M8", Confirmed(task="G8", epoch=1), at_s=10.02)
    rival = Transport(item="seal-kit", quantity=40, sources=("S6",), destination="M7", ability="tote")
    stage.say("M7", "ATV3", _award("M7-1", rival), at_s=10.9)
    stage.run(until_s=95.0)
    return stage


def _award(task: str, work: Production | Transport) -> Award:
    return Award(task=task, epoch=1, role=Role.PRIMARY, work=work, deadline_s=3600.0)


def test_figure_3_is_played_message_by_message() -> None:
    """Compare with the golden file; its prose says what it proves. Rewrite it by running this file."""
    assert rewritten(GOLDEN, play()) == GOLDEN.read_text(encoding="utf-8")


def test_the_cheapest_bidder_is_asked_first_and_the_next_best_wins() -> None:
    facts = play().facts
    bids = [fact for agent, fact in facts if agent == "M8" and isinstance(fact, BidReceived)]
    costs_s = {bid.bidder: bid.total_s for bid in bids if bid.role is Role.PRIMARY}
    assert sorted(costs_s, key=costs_s.__getitem__) == ["ATV3", "ATV2", "ATV1"]
    given = [fact for agent, fact in facts if agent == "M8" and isinstance(fact, AwardGiven)]
    assert [(fact.bidder, fact.role) for fact in given] == [
        ("ATV3", Role.PRIMARY),
        ("ATV2", Role.PRIMARY),
        ("ATV1", Role.SECONDARY),
    ]
    answered = [fact for agent, fact in facts if agent == "M8" and isinstance(fact, AwardAnswered)]
    assert [fact.reason or fact.answer for fact in answered] == ["busy", "accepted", "accepted"]


if __name__ == "__main__":
    GOLDEN.write_text(rewritten(GOLDEN, play()), encoding="utf-8")
