"""What `dray plant ready` finds of disks and clocks."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from ready_kit import NOW_S, WORKSHOP, answers, heard, of, picture, seen

from dray.cli.runtime.ready.answers import Clock
from dray.cli.runtime.ready.computer import clocks, disks
from dray.cli.runtime.ready.finding import Verdict
from dray.settings import Settings

GIB = 2**30


def free(count: float) -> Callable[[Path], int]:
    return lambda _folder: round(count)


def test_a_disk_has_to_have_room_for_the_days_that_are_kept(tmp_path: Path) -> None:
    here = Settings.load(database_url=f"sqlite:///{tmp_path / 'd.db'}", journal_folder=tmp_path / "journals")
    # Two vehicles: 500 facts of 500 bytes an hour each in 14 days, and a GiB for all else.
    wanted = 2 * 500 * 500 * 24 * 14 + GIB
    enough = {each.name: each.verdict for each in disks(WORKSHOP, here, free(wanted))}
    assert set(enough.values()) == {Verdict.OK}
    found = {each.name: each.verdict for each in disks(WORKSHOP, here, free(wanted - 1))}
    assert found == {"disk of the database": Verdict.MISSING, "disk of the journals": Verdict.OK}
    assert of("disk of the journals", disks(WORKSHOP, here, free(GIB - 1))).verdict is Verdict.MISSING
    many = here.model_copy(update={"events_most": 1000})
    assert of("disk of the database", disks(WORKSHOP, many, free(GIB + 500_000))).verdict is Verdict.OK


def test_what_a_database_has_taken_is_not_wanted_again(tmp_path: Path) -> None:
    here = Settings.load(database_url=f"sqlite:///{tmp_path / 'd.db'}", journal_folder=tmp_path)
    (tmp_path / "d.db").write_bytes(bytes(100_000_000))
    needed = 2 * 500 * 500 * 24 * 14 + GIB - 100_000_000
    assert of("disk of the database", disks(WORKSHOP, here, free(needed))).verdict is Verdict.OK
    assert of("disk of the database", disks(WORKSHOP, here, free(needed - 1))).verdict is Verdict.MISSING


def test_the_disk_of_a_database_elsewhere_cannot_be_seen() -> None:
    here = Settings.load(database_url="postgresql://dray@db.plant/dray")
    found = of("disk of the database", disks(WORKSHOP, here, free(100 * GIB)))
    assert seen(found, Verdict.UNKNOWN, "it is on db.plant")


@pytest.mark.parametrize(
    ("synchronised", "verdict"),
    [(True, Verdict.OK), (False, Verdict.MISSING), (None, Verdict.UNKNOWN)],
)
def test_a_computer_has_to_keep_its_clock_right(synchronised: bool | None, verdict: Verdict) -> None:
    found = list(clocks(None, lambda: synchronised))
    assert [(each.name, each.verdict) for each in found] == [("clock of this computer", verdict)]


@pytest.mark.parametrize(
    ("ahead_s", "verdict", "said"),
    [
        # The gateway tells whole seconds up to a second old; clocks of one plant agree within a second.
        (0.0, Verdict.OK, "agrees"),
        (1.0, Verdict.OK, "agrees"),
        (1.4, Verdict.MISSING, "at least 1 s ahead of"),
        (-3.0, Verdict.OK, "agrees"),
        (-3.1, Verdict.MISSING, "at least 1 s behind"),
        (3600.0, Verdict.MISSING, "at least 3600 s ahead of"),
    ],
)
def test_the_clock_of_the_gateway_is_compared_as_far_as_it_is_told(
    ahead_s: float, verdict: Verdict, said: str
) -> None:
    told = answers(clock=(NOW_S, NOW_S + ahead_s, NOW_S))
    assert seen(of("clock of the gateway", clocks(told, lambda: True)), verdict, said)


def test_a_slow_answer_makes_no_clock_wrong() -> None:
    told = answers(clock=(NOW_S, NOW_S + 9.0, NOW_S + 10.0))
    assert of("clock of the gateway", clocks(told, lambda: True)).verdict is Verdict.OK
    assert of("clock of the gateway", clocks(answers(), lambda: True)).verdict is Verdict.UNKNOWN


def test_an_agent_whose_clock_is_wrong_is_named() -> None:
    wrong = heard("CART1", clock=Clock(ahead_s=42.0, wrong=True))
    right = heard("CART2", clock=Clock(ahead_s=0.2, wrong=False))
    found = of("clocks of the agents", clocks(answers(picture(atvs=(wrong, right))), lambda: True))
    assert (found.verdict, found.seen) == (Verdict.MISSING, "wrong: CART1 (+42.0 s)")
