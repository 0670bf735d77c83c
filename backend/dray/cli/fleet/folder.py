"""The folder of a fleet: its layout, and the files needed before the start."""

from __future__ import annotations

import contextlib
import fcntl
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import msgspec

from dray.adapters.journal.sqlite_journal import SqliteJournal
from dray.adapters.processes import PROC
from dray.adapters.security.certificates import Authority
from dray.cli.runtime.options import load_settings
from dray.cli.runtime.roster import FLOOR, agents_of
from dray.errors import UnavailableError
from dray.messages.keys import GATE
from dray.messages.kinds import Kind
from dray.messages.speakers import names_of
from dray.plant import Plant
from dray.settings import PREFIX, Settings

REGISTRY, SETTINGS, CERTIFICATES, JOURNALS, LOGS = "fleet.json", "fleet.env", "certs", "journals", "logs"
METRICS = "metrics.json"
CONTROLLERS = "controllers"
"""The folder of mapping files, for machines, storages and a gate with controllers."""

FLEET_LOCK, UPDATE_LOCK = "fleet.lock", "update.lock"

GATEWAY, HISTORIAN = "gateway", "historian"
"""The names of their processes, and of their certificates."""

OBSERVER = "observer"
"""The name of the certificate for commands that observe a fleet."""


def make(folder: Path) -> None:
    """Create the folder of a fleet, if it is missing.

    Raises:
        UnavailableError: creating it failed, or this computer does not support a fleet.
    """
    if not (PROC / "self").exists():
        raise UnavailableError("a fleet", "needs Linux, where /proc tells who runs", "use `dray up` here")
    with _kept_in(folder):
        (folder / LOGS).mkdir(parents=True, exist_ok=True)


def prepare(folder: Path, plant: Plant, strategists: Sequence[str], *, plain: bool) -> None:
    """Prepare the folder for a new fleet.

    Args:
        folder: the fleet's folder.
        plant: the plant; its agents get certificates.
        strategists: the strategists; they get certificates, too.
        plain: whether links have no certificates.

    Raises:
        UnavailableError: writing failed.
    """
    with _kept_in(folder):
        _forget_bodies(folder)
        if not plain:
            _certify(plant, strategists, folder / CERTIFICATES)


@contextlib.contextmanager
def alone(folder: Path, lock: str, what: str, remedy: str) -> Iterator[None]:
    """Hold a lock on this folder, so that only one process does this; it ends with our process in any case.

    Args:
        folder: an existing folder.
        lock: the name of a file in it.
        what: the work to be done.
        remedy: the advice when another process holds the lock.

    Raises:
        UnavailableError: another process holds the lock.
    """
    with _kept_in(folder):
        file = (folder / lock).open("ab")
    with file as held:
        try:
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise UnavailableError(what, f"another one is at work in {folder}", remedy) from None
        yield


def read_settings(folder: Path) -> Settings:
    """The settings of a fleet at its start, independent of our own environment.

    Raises:
        UnavailableError: there are none.
    """
    try:
        lines = (folder / SETTINGS).read_text(encoding="utf-8").splitlines()
    except OSError as error:
        raise UnavailableError(
            str(folder / SETTINGS), error.strerror or str(error), "start a fleet with `dray fleet up`"
        ) from None
    pairs = (line.partition("=") for line in lines)
    return load_settings(
        None, **{name.removeprefix(PREFIX).lower(): value for name, _, value in pairs if value}
    )


def write_settings(folder: Path, common: Mapping[str, str], peers: Sequence[str]) -> None:
    """Write the settings for a joining agent: those of all, and some addresses to call.

    Raises:
        UnavailableError: writing failed.
    """
    file = folder / SETTINGS
    lines = [f"{name}={value}" for name, value in (*common.items(), (f"{PREFIX}BUS_PEERS", ",".join(peers)))]
    # The URL of the database may contain a password.
    with _kept_in(folder):
        file.unlink(missing_ok=True)
        file.touch(mode=0o600)
        file.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_targets(folder: Path, targets: Mapping[str, str]) -> None:
    """Write the metrics addresses in Prometheus' format (`file_sd_configs`).

    Args:
        folder: the fleet's folder.
        targets: the addresses by names of processes.

    Raises:
        UnavailableError: writing failed.
    """
    found = [{"targets": [address], "labels": {"instance": name}} for name, address in targets.items()]
    with _kept_in(folder):
        (folder / METRICS).write_bytes(msgspec.json.format(msgspec.json.encode(found)) + b"\n")


def _certify(plant: Plant, strategists: Sequence[str], folder: Path) -> None:
    """A certificate for every process, by an authority of this fleet, which may certify joining agents."""
    authority = Authority.make(plant.id)
    authority.write(folder)
    kinds = {
        FLOOR: Kind.HISTORIAN,
        HISTORIAN: Kind.HISTORIAN,
        OBSERVER: Kind.HISTORIAN,
        **dict.fromkeys(strategists, Kind.STRATEGIST),
        GATEWAY: Kind.GATEWAY,
        **agents_of(plant),
    }
    for name, kind in kinds.items():
        authority.issue(folder, plant.id, names_of(name, kind))


def forget_controllers(folder: Path, plant: Plant) -> None:
    """Delete the addresses and counts of the last floor's controllers: a new floor has other ones.

    Raises:
        UnavailableError: deleting failed.
    """
    with _kept_in(folder):
        names = ((plant.machines, "workcell"), (plant.stores, "store"), ((GATE,), "signals"))
        for name, body in ((name, body) for kind, body in names for name in kind):
            for file in (
                folder / CONTROLLERS / f"{name}.yaml",
                folder / JOURNALS / f"{name}.{body}.json",
            ):
                file.unlink(missing_ok=True)


def _forget_bodies(folder: Path) -> None:
    """The floor begins anew, so agents' commitments about the last one are void."""
    for file in (folder / JOURNALS).glob("*.db"):
        with contextlib.closing(SqliteJournal(file)) as journal:
            journal.forget()


@contextlib.contextmanager
def _kept_in(folder: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        raise UnavailableError(str(folder), reason, "choose another --folder") from None
