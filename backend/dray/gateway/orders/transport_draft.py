"""A plain transport as people and programs ask for it."""

from __future__ import annotations

from typing import Annotated
from unicodedata import category

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, StringConstraints

from dray.gateway.orders.drafts import DueMoment
from dray.priorities import Priority

WISH_S = 300.0
"""Of the plant's clock: how long one vehicle is waited for that is only wished for. What is urgent is due within one minute, all else later."""

THING_MAX = 100
"""Characters of what people call a thing: one line of a list."""


_PlantId = Annotated[str, Field(min_length=1, max_length=32, pattern=r"^[A-Za-z][A-Za-z0-9_.-]*$")]


def _seen(thing: str) -> str:
    """Refuse what nobody sees, and what turns the rest of a line round.

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
    """Something to be brought from one place to another."""

    model_config = ConfigDict(extra="forbid", populate_by_name=True)

    source: Annotated[_PlantId | None, Field(alias="from")] = None
    """A storage, or a machine that has it in a buffer. Left out, the nearest storage that has enough."""
    to: _PlantId | None = None
    """Likewise. Left out, the nearest storage that has room; one of both must be named."""
    item: _PlantId | None = None
    """A material; `GET /api/materials` lists them, and where they are kept. Left out where it is a `thing`."""
    thing: _Thing | None = None
    """Instead of an item: something without master data, as people call it ("pump housing for Meier", "empty pallet"). It needs `from`, `to` and `ability`, and is counted
    in no stock."""
    quantity: Annotated[int | None, Field(strict=True, ge=1, le=10_000)] = None
    """Pieces: one load, so at most the lot of the material. A thing is one, and needs none said."""
    due_at: DueMoment | None = None
    """When it should be there, with a time zone; not in the past."""
    not_before: DueMoment | None = None
    """When it may be given out at the soonest; before `due_at`. One that is past means at once."""
    priority: Priority = Priority.NORMAL
    vehicle: _PlantId | None = None
    """The only vehicle that may carry it."""
    vehicle_only: Annotated[bool, Field(strict=True)] = True
    """Whether it waits for that one for always; false for a wish, which ends after five minutes of the plant's clock: then any may carry it."""
    ability: _PlantId | None = None
    """What its vehicle must be able to carry beside what the material asks for: one of the abilities of the plant's types of vehicles, as `pallet`. Of a
    thing: what it is carried as."""

    def text(self) -> str:
        """What was asked, in JSON: the same for the same, also of an earlier version."""
        left_out = {name for name in ("ability", "not_before", "thing") if getattr(self, name) is None}
        return self.model_dump_json(exclude=left_out | ({"vehicle_only"} if self.vehicle_only else set()))
