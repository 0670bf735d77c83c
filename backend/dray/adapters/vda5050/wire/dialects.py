"""The supported versions of VDA 5050, as one table: the differences between 2.0, 2.1 and 3.0 in a master's messages.

Sources: VDA5050_EN.md and the folder json_schemas at the tags 2.0.0, 2.1.0 and 3.0.0. Reading needs no table: `messages` knows the
names of all versions at once.
"""

from __future__ import annotations

from typing import Literal, get_args

import msgspec

from dray.errors import SettingsError

Version = Literal["2.0", "2.1", "3.0"]


class Dialect(msgspec.Struct, frozen=True):
    """One version."""

    version: str
    """The version in the header of every message."""
    prefix: str
    """The suggested prefix of topics, before MANUFACTURER/SERIAL."""
    deviation: str
    """A node's field for the allowed deviation."""
    is_ellipse: bool
    """Whether the deviation is an object of two axes and an angle, instead of a radius in metres."""
    max_speed: str
    """An edge's field for its limit."""
    names_ends: bool
    """Whether an edge names the nodes at its ends."""
    action_names: tuple[str, ...]
    """An instant action's fields for its type: the schema of 2.0 differs from its text, so both are written."""


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
        SettingsError: the version is not supported.
    """
    for known in get_args(Version):
        if version == known:
            return DIALECTS[known]
    raise SettingsError("version", f"{version!r} is none of {', '.join(DIALECTS)}")
