"""The draft of a plain transport, from a person or program."""

from __future__ import annotations

from typing import Annotated
from unicodedata import category

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, StringConstraints

from dray.gateway.orders.drafts import DueMoment
from dray.priorities import Priority

WISH_S = 300.0
"""Plant seconds for which a preferred vehicle is awaited. An urgent transport is due within one minute,
others later."""

THING_MAX = 100
"""Maximum characters of a thing's name: one line of a list."""


_PlantId = Annotated[str, Field(min_length=1, max_length=32, pattern=r"^[A-Za-z][A-Za-z0-9_.-]*$")]


def _seen(thing: str) -> str:
    """Refuse invisible characters and those that reverse text.

    Raises:
        ValueError: it holds such a character.
    """
    for character in thing:
        if category(character) in ("Cc", "Cf", "Zl", "Zp"):
            raise ValueError(f"holds a character that nobody sees (U+{ord(character):04X})")
    return thing


_Thing = Annotated[
    str,
    StringConstraints(
        strip_whitespace=True, min_length=1, max_length=THING_MAX, pattern=r"^[^\x00-\x1f\x7f]+$"
    ),
    AfterValidator(_seen),
]


class TransportDraft(BaseModel):
    """Something to bring from one place to another."""

    model_config = ConfigDict(extra="forbid", populate_by_name=True)

    source: Annotated[_PlantId | None, Field(alias="from")] = None
    """A storage, or a machine with the item in a buffer. Without it: the nearest storage that has enough."""
    to: _PlantId | None = None
    """A storage or machine. Without it: the nearest storage with room. One of both must be named."""
    item: _PlantId | None = None
    """A material; `GET /api/materials` lists them and their storages. Left out for a `thing`."""
    thing: _Thing | None = None
    """Instead of an item: something without master data, by its everyday name ("pump housing for Meier",
    "empty pallet"). Needs `from`, `to` and `ability`; counts in no stock."""
    quantity: Annotated[int | None, Field(strict=True, ge=1, le=10_000)] = None
    """Pieces of one load, at most the material's lot. A thing counts as one."""
    due_at: DueMoment | None = None
    """When it should arrive, with a time zone; not in the past."""
    not_before: DueMoment | None = None
    """Earliest time to announce it; before `due_at`. A past time means at once."""
    priority: Priority = Priority.NORMAL
    vehicle: _PlantId | None = None
    """The only vehicle that may carry it."""
    vehicle_only: Annotated[bool, Field(strict=True)] = True
    """Whether to wait for that vehicle forever; if false, any vehicle may carry it after five minutes of the
    plant's clock."""
    ability: _PlantId | None = None
    """Ability that its vehicle needs beside the material's: one of the vehicle types' abilities, such as
    `pallet`. For a thing: how it is carried."""

    def text(self) -> str:
        """The draft as JSON: equal for equal drafts, also across versions."""
        left_out = {name for name in ("ability", "not_before", "thing") if getattr(self, name) is None}
        return self.model_dump_json(exclude=left_out | ({"vehicle_only"} if self.vehicle_only else set()))
