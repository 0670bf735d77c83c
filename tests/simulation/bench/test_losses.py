"""The benchmark that kills: a fleet that does not do what it should is told, and a small one survives a few kills."""

from __future__ import annotations

import asyncio
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "cli/fleet"))

from losses_kit import SMALL, Ailing, Deaf
from registries import NOBODY, write_registry

from dray.adapters.processes import Process
from dray.adapters.zenoh.tokens import Tokens
from dray.cli.fleet.folder import LOGS, REGISTRY, write_settings
from dray.errors import UnavailableError
from dray.messages.keys import Keys
from dray_sim.bench.losses import campaign
from dray_sim.bench.losses.campaign import Outcome
from dray_sim.bench.losses.figures import rows
from dray_sim.bench.losses.fleet import Fleet, running
from dray_sim.bench.losses.judgement import ENDED, judge
from dray_sim.bench.losses.victims import LASTING, Kind
from dray_sim.bench.losses.watch import gathered
from dray_sim.bench.postgres import PostgresServer

PATIENCE_S = 30.0
"""Real seconds for what takes a moment."""


# --- a fleet that does not do what it should --------------------------------------------------------


@pytest.mark.parametrize(
    ("ended", "told"),
    [
        (True, "fleet.json: no such file"),
        (False, r"(\w+), \w+: not back in 0 s; the log of \1 ends with: Aargh"),
    ],
    ids=["has ended", "does not come back"],
)
def test_a_fleet_that_ends_or_does_not_recover_ends_the_campaign_with_the_reason(
    monkeypatch: pytest.MonkeyPatch, ended: bool, told: str
) -> None:
    monkeypatch.setattr(campaign, "RETURN_S", 0.0)
    plan: Any = replace(SMALL, quiet_s=0.0, pause_s=0.01, head_start_s=0.0)
    paper: Any = Ailing(ended=ended), Deaf(), None, None

    async def play() -> None:
        async with asyncio.timeout(PATIENCE_S):
            await campaign._Field(plan, *paper).play()

    with pytest.raises(UnavailableError, match=told):
        asyncio.run(play())


class Bus:
    """A bus on which nobody is."""

    keys = Keys("plant")
    tokens = Tokens(keys.alive, None, print)

    @property
    def inner(self) -> Any:
        return self

    def join(self, name: str, on_message: object) -> Any:
        return self

    def subscribe(self, key: str) -> None:
        pass

    def liveliness(self) -> Any:
        return self

    def declare_subscriber(self, key: str, on_sample: object, *, history: bool) -> None:
        pass


DEAF_TO_SIGNALS = """\
#!/bin/sh
trap '' TERM
echo "2 processes; all of them were started"
while true; do sleep 0.1; done
"""


def write_fleet(folder: Path, *pids: int) -> None:
    """A fleet's folder whose supervisor has ended and whose processes have not."""
    write_registry(folder, NOBODY, *map(Process.of, pids))
    write_settings(folder, {"DRAY_PORT": "4711", "DRAY_DATABASE_URL": f"sqlite:///{folder / 'fleet.db'}"}, ())
    (folder / LOGS).mkdir()


def test_whoever_is_not_there_in_time_is_named_with_what_it_has_said(tmp_path: Path) -> None:
    with subprocess.Popen(["sleep", "60"]) as member:
        write_fleet(tmp_path, member.pid)
        (tmp_path / LOGS / "ATV1.log").write_text("first\n" * 20 + "no floor\n")
        bus: Any = Bus()
        with pytest.raises(UnavailableError, match=r"(?s)ATV1: not on the bus in 0 s; .*first\nno floor$"):
            asyncio.run(gathered(Fleet(tmp_path, "t"), bus, 0.0))
        member.kill()


def test_a_fleet_is_known_by_its_folder_whatever_the_environment_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_fleet(tmp_path)
    monkeypatch.setenv("DRAY_DATABASE_URL", "sqlite:///elsewhere.db")
    monkeypatch.setenv("DRAY_PORT", "80")
    fleet = Fleet(tmp_path, "t")
    assert fleet.database_url.endswith(f"{tmp_path}/fleet.db")
    assert fleet.url == "http://127.0.0.1:4711"


TELLS_HOW_IT_WAS_STARTED = """\
#!/bin/sh
env | grep ^DRAY_ | cut -d= -f1 > "$0.env"
echo "$@" > "$0.options"
echo "2 processes; all of them were started"
exec sleep 60
"""


def test_a_fleet_knows_nothing_of_the_database_and_the_settings_of_whoever_measures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DRAY_DATABASE_URL", "postgresql://shop@db/shop")
    monkeypatch.setenv("DRAY_LEAVE_S", "1")
    python = tmp_path / "python"
    python.write_text(TELLS_HOW_IT_WAS_STARTED)
    python.chmod(0o700)
    monkeypatch.setattr("sys.executable", str(python))
    write_fleet(tmp_path)

    async def story() -> None:
        async with running(tmp_path, SMALL.plant, speed=1.0, plain=True):
            pass

    asyncio.run(story())
    assert Path(f"{python}.env").read_text().split() == ["DRAY_ADMIN_TOKEN"]
    assert f"--db sqlite:///{tmp_path}/dray.db" in Path(f"{python}.options").read_text()


def test_a_fleet_that_does_not_end_is_killed_with_all_its_processes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("dray_sim.bench.losses.fleet.STOP_S", 0.0)
    python = tmp_path / "python"
    python.write_text(DEAF_TO_SIGNALS)
    python.chmod(0o700)
    monkeypatch.setattr("sys.executable", str(python))

    async def story() -> None:
        async with running(tmp_path, SMALL.plant, speed=1.0, plain=True):
            pass

    # Whoever runs the tests in the background of a shell has them, and what they start, ignore that signal.
    with subprocess.Popen(["env", "--default-signal=INT", "sleep", "60"]) as member:
        write_fleet(tmp_path, member.pid)
        asyncio.run(story())
        assert member.wait(PATIENCE_S) == -signal.SIGINT
    assert not (tmp_path / REGISTRY).exists()


# --- a small fleet ----------------------------------------------------------------------------------


@pytest.mark.campaign
@pytest.mark.timeout(1500)  # it ends when all has arrived, however busy the computer is
def test_a_small_fleet_loses_nothing_when_one_of_every_kind_is_killed(
    tmp_path: Path, mortal_postgres: PostgresServer
) -> None:
    outcome: Outcome = asyncio.run(campaign.play(SMALL, tmp_path, mortal_postgres))
    # The last one may have been a machine with all that carry for it.
    assert len(outcome.kills) + len(outcome.outages) >= SMALL.kills
    assert outcome.outages
    assert all(kill.away_s is not None for kill in outcome.kills)
    assert {Kind.MACHINE, Kind.STRATEGIST, Kind.HISTORIAN, Kind.GATEWAY} <= {
        kill.victim.kind for kill in outcome.kills
    }
    assert any(kill.victim.kind in LASTING for kill in outcome.kills)
    findings = judge(outcome.after)
    # Beside other tests a process may find no way to its body for so long that it gives up and is started again.
    lost = {finding.what: finding.seen for finding in findings if finding.what != ENDED}
    assert not any(lost.values()), lost
    assert all(finding.of for finding in findings)
    figures = rows(outcome)
    assert all(row.met for row in figures if ENDED not in row.name)
    assert {f"losses: {kill.victim.kind}, away" for kill in outcome.kills} <= {row.name for row in figures}
