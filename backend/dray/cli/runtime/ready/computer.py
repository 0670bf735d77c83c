"""This computer: its clock, and the space on its disks."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

from sqlalchemy import make_url

from dray.cli.runtime.ready.answers import Answers
from dray.cli.runtime.ready.finding import Finding, missing, named, ok, unknown
from dray.messages.base import CLOCKS_AGREE_S
from dray.plant import Plant
from dray.settings import Settings

DATE_S = 2.0
"""Precision of a gateway's date: whole seconds, updated once a second."""

FACTS_PER_H = 500
"""Facts per hour of one vehicle with its transports, in real time: 1,000 vehicles send a million in two hours."""

FACT_BYTES = 500
"""Size of one fact in the database, with its indexes."""

REST_BYTES = 2**30
"""Space for recordings, figures, orders and logs, and for journals: some tens of vehicles fill it in months."""

LOOK_S = 5.0
"""Timeout of the time service, which answers at once."""


def clocks(answers: Answers | None, ntp: Callable[[], bool | None]) -> Iterator[Finding]:
    """Whether this computer's clock is synchronised, and those of the gateway and of the agents agree.

    Args:
        answers: the gateway's answers; None where it does not answer.
        ntp: whether this computer's clock is synchronised; None if unknown.
    """
    synchronised = ntp()
    todo = "timedatectl set-ntp true, or install chrony; clocks must agree within 100 ms"
    if synchronised is None:
        yield unknown("clock of this computer", "no time service answers (timedatectl)", todo)
    elif synchronised:
        yield ok("clock of this computer", "it is synchronised (NTP)")
    else:
        yield missing("clock of this computer", "it is not synchronised (NTP)", todo)
    if answers is None:
        return
    yield _gateway(answers.clock)
    wrong = [
        f"{each.id} ({each.clock.ahead_s:+.1f} s)"
        for each in answers.picture.agents().values()
        if each.clock is not None and each.clock.wrong
    ]
    if wrong:
        yield missing("clocks of the agents", f"wrong: {named(wrong)}", f"on its computer: {todo}")
    else:
        yield ok("clocks of the agents", "none is known to be wrong")


def _gateway(clock: tuple[float, float, float] | None) -> Finding:
    name = "clock of the gateway"
    if clock is None:
        return unknown(name, "its answers have no date")
    asked_s, told_s, answered_s = clock
    # The gateway's time is in the interval of `DATE_S` from `told_s`, and was taken between question and answer.
    ahead_s, behind_s = told_s - answered_s, asked_s - (told_s + DATE_S)
    if max(ahead_s, behind_s) > CLOCKS_AGREE_S:
        off = f"{ahead_s:.0f} s ahead of" if ahead_s > 0 else f"{behind_s:.0f} s behind"
        return missing(name, f"at least {off} this computer's", "set both by NTP: timedatectl set-ntp true")
    return ok(name, f"it agrees with this computer's, to {DATE_S:g} s")


def ntp_synchronised() -> bool | None:
    """Whether the kernel considers this computer's clock synchronised; None without systemd's answer."""
    tool = shutil.which("timedatectl")
    if tool is None:
        return None
    try:
        done = subprocess.run(  # noqa: S603 - a fixed command
            [tool, "show", "--property=NTPSynchronized", "--value"],
            capture_output=True,
            text=True,
            timeout=LOOK_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    return {"yes": True, "no": False}.get(done.stdout.strip())


def disks(plant: Plant, settings: Settings, free_bytes: Callable[[Path], int]) -> Iterator[Finding]:
    """Whether there is space for the database and for journals.

    Args:
        plant: the plant, with its number of vehicles.
        settings: the locations of both, and the retention of facts.
        free_bytes: free space on the disk of a folder.
    """
    facts = min(settings.events_most, FACTS_PER_H * 24 * settings.events_days * max(1, len(plant.fleet)))
    wanted = round(facts * FACT_BYTES) + REST_BYTES
    url = make_url(settings.database_url)
    if url.get_backend_name() == "sqlite":
        file = Path(url.database or "")
        wanted = max(REST_BYTES, wanted - (file.stat().st_size if file.is_file() else 0))
        yield _disk("disk of the database", file.parent, wanted, free_bytes)
    else:
        seen = f"it is on {url.host or 'this computer'}; facts of {settings.events_days:g} days take {_gib(wanted)}"
        yield unknown("disk of the database", seen, "df -h there")
    yield _disk("disk of the journals", settings.journal_folder, REST_BYTES, free_bytes)


def _disk(name: str, folder: Path, wanted: int, free_bytes: Callable[[Path], int]) -> Finding:
    there = next((each for each in (folder, *folder.absolute().parents) if each.is_dir()), None)
    if there is None:
        return missing(name, f"there is no {folder}", f"mkdir -p {folder}")
    free = free_bytes(there)
    seen = f"{_gib(free)} free in {there.absolute()}, {_gib(wanted)} needed"
    if free < wanted:
        return missing(name, seen, "a larger disk, or fewer days: DRAY_EVENTS_DAYS, DRAY_REPLAY_DAYS")
    return ok(name, seen)


def free_on(folder: Path) -> int:
    """Free bytes on the disk of a folder."""
    return shutil.disk_usage(folder).free


def _gib(count: int) -> str:
    return f"{count / 2**30:.1f} GiB"
