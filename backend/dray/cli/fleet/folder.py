"""The folder of a fleet: what is where in it, and what lies there before anything starts."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import msgspec

from dray.adapters.certificates import Authority
from dray.adapters.sqlite_journal import SqliteJournal
from dray.cli.process import FLOOR
from dray.errors import UnavailableError
from dray.messages.speakers import Kind
from dray.plant import Plant
from dray.protocol.strategist import STRATEGIST
from dray.settings import PREFIX
from dray.worker import HISTORY_FACTS

ROLL, SETTINGS, CERTIFICATES, JOURNALS, LOGS = "fleet.json", "fleet.env", "certs", "journals", "logs"
METRICS = "metrics.json"

GATEWAY, HISTORIAN = "gateway", "historian"
"""The names of their processes, and of their certificates."""


def prepare(folder: Path, plant: Plant, *, plain: bool) -> None:
    """Make the folder ready for a fleet that begins anew.

    Args:
        folder: made if need be.
        plant: whose agents get certificates.
        plain: links have none.

    Raises:
        UnavailableError: it cannot be written.
    """
    with _kept_in(folder):
        (folder / LOGS).mkdir(parents=True, exist_ok=True)
        _forget_bodies(folder)
        if not plain:
            _certify(plant, folder / CERTIFICATES)


def write_settings(folder: Path, common: Mapping[str, str], peers: Sequence[str]) -> None:
    """Write down what a newcomer needs: the settings of all, and some addresses to call."""
    file = folder / SETTINGS
    lines = [f"{name}={value}" for name, value in (*common.items(), (f"{PREFIX}BUS_PEERS", ",".join(peers)))]
    # The URL of the database may hold a password.
    file.unlink(missing_ok=True)
    file.touch(mode=0o600)
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_targets(folder: Path, targets: Mapping[str, str]) -> None:
    """Write down where Prometheus can ask, in its own words (`file_sd_configs`).

    Args:
        folder: the fleet's.
        targets: by the process's name, its address.
    """
    found = [{"targets": [address], "labels": {"instance": name}} for name, address in targets.items()]
    (folder / METRICS).write_bytes(msgspec.json.format(msgspec.json.encode(found)) + b"\n")


def _certify(plant: Plant, folder: Path) -> None:
    """A certificate for every process, by an authority of this fleet, which may certify newcomers."""
    authority = Authority.make(plant.id)
    authority.write(folder)
    kinds = {
        FLOOR: Kind.HISTORIAN,
        HISTORIAN: Kind.HISTORIAN,
        STRATEGIST: Kind.STRATEGIST,
        GATEWAY: Kind.GATEWAY,
        **dict.fromkeys(plant.machines, Kind.MACHINE),
        **dict.fromkeys(plant.fleet, Kind.ATV),
    }
    for name, kind in kinds.items():
        authority.issue(folder, plant.id, {name: kind})


def _forget_bodies(folder: Path) -> None:
    """The floor begins anew, so what agents were bound by to the last one is no more."""
    for file in (folder / JOURNALS).glob("*.db"):
        with contextlib.closing(SqliteJournal(file, events_kept=HISTORY_FACTS)) as journal:
            journal.forget()


@contextlib.contextmanager
def _kept_in(folder: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        raise UnavailableError(str(folder), reason, "choose another --folder") from None
