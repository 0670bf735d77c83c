"""A folder of certificates for each process of a plant: a container sees only its own."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from dray.adapters.security.certificates import AUTHORITY, REVOKED, Authority
from dray.cli.compose.document import services_of
from dray.errors import SettingsError, UnavailableError
from dray.messages.keys import STRATEGISTS
from dray.messages.kinds import Kind
from dray.messages.speakers import names_of
from dray.plant import Plant

USER = 10001
"""The user id of the image's processes (`Dockerfile`)."""

_KINDS = {"gateway": Kind.GATEWAY, **dict.fromkeys(STRATEGISTS, Kind.STRATEGIST)}
"""Kinds of the single processes; the others are no agents."""


def certify(plant: Plant, folder: Path, strategists: int = 1) -> int:
    """Write missing files: the authority into `folder`, and below it a folder for each process.

    Copies of the list of revoked certificates are updated, too.

    Returns:
        The number of new certificates.

    Raises:
        SettingsError: the authority there belongs to another plant.
        UnavailableError: writing failed.
    """
    try:
        return _certify(plant, folder, strategists)
    except OSError as error:
        raise UnavailableError(
            str(folder), error.strerror or str(error), "choose another --folder, or ask as its owner"
        ) from None


def _certify(plant: Plant, folder: Path, strategists: int) -> int:
    if (folder / f"{AUTHORITY}.pem").exists():
        authority = Authority.load(folder)
        if authority.plant != plant.id:
            raise SettingsError(
                str(folder), f"has the authority of {authority.plant}, and not of {plant.id}: move it away"
            )
    else:
        authority = Authority.make(plant.id)
        authority.write(folder)
    made = 0
    for service in services_of(plant, strategists):
        agent, own = service.agent, folder / service.agent
        own.mkdir(mode=0o700, exist_ok=True)
        if not (own / f"{agent}.pem").exists():
            kind = service.kind or _KINDS.get(agent, Kind.HISTORIAN)
            authority.issue(folder, plant.id, names_of(agent, kind))
            for end in ("key", "pem"):
                shutil.move(folder / f"{agent}.{end}", own / f"{agent}.{end}")
            made += 1
        for shared in (f"{AUTHORITY}.pem", f"{REVOKED}.pem"):
            if (folder / shared).exists():
                shutil.copy(folder / shared, own / shared)
        _give_away(own)
    return made


def _give_away(folder: Path) -> None:
    """Let the image's user read it, where we may; otherwise the person who starts the containers must."""
    if os.geteuid() == 0:
        for path in (folder, *folder.iterdir()):
            os.chown(path, USER, USER)
