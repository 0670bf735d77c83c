"""The versions of VDA 5050 that are spoken, as one table: what differs between 2.0, 2.1 and 3.0 in what a master says.

Sources: VDA5050_EN.md and the folder json_schemas at the tags 2.0.0, 2.1.0 and 3.0.0. What vehicles say is read without
a table: `messages` knows the names of all versions at once.
"""

from __future__ import annotations

from typing import Literal, get_args

import msgspec

from dray.errors import SettingsError

Version = Literal["2.0", "2.1", "3.0"]


class Dialect(msgspec.Struct, frozen=True):
    """One version."""

    version: str
    """As the header of every message has it."""
    prefix: str
    """Of topics, as the text suggests it; before MANUFACTURER/SERIAL."""
    deviation: str
    """How a node names the allowed deviation."""
    is_ellipse: bool
    """Whether that is an object of two axes and an angle, and no radius in metres."""
    max_speed: str
    """How an edge names its limit."""
    names_ends: bool
    """Whether an edge names the nodes at its ends."""
    action_names: tuple[str, ...]
    """How an instant action names its type: the schema of 2.0 says it otherwise than its text, so both are said."""


DIALECTS: dict[Version, Dialect] = {
    "2.0": Dialect(
        version="2.0.0",
        prefix="uagv/v2",
        deviation="allowedDeviationXy",
        is_ellipse=False,
        max_speed="maxSpeed",
        names_ends=True,
        action_names=("actionType", "actionName"),
    ),
    "2.1": Dialect(
        version="2.1.0",
        prefix="uagv/v2",
        deviation="allowedDeviationXY",
        is_ellipse=False,
        max_speed="maxSpeed",
        names_ends=True,
        action_names=("actionType",),
    ),
    "3.0": Dialect(
        version="3.0.0",
        prefix="vda5050/v3",
        deviation="allowedDeviationXY",
        is_ellipse=True,
        max_speed="maximumSpeed",
        names_ends=False,
        action_names=("actionType",),
    ),
}


def dialect_of(version: str) -> Dialect:
    """The dialect of a version.

    Raises:
        SettingsError: nobody speaks that.
    """
    for known in get_args(Version):
        if version == known:
            return DIALECTS[known]
    raise SettingsError("version", f"{version!r} is none of {', '.join(DIALECTS)}")
