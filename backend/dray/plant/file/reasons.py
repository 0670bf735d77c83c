"""Reasons of faults in products, in English and by a code, so that others tell them in other languages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Self

TEXTS: Mapping[str, str] = {
    "plant_unknown": "there is no {name} in `{section}`: {advice}",
    "plant_no_buffer": "{name} is a product without a `buffer`: say there how many pieces a machine holds that uses it",
    "plant_implausible": "{value} is not within {least} to {most}: check the unit",
    "plant_ability": "no vehicle of the fleet can carry {ability}: {item} would never move",
    "plant_lot": "a lot of {lot} does not fit into a buffer of {buffer}",
    "plant_not_stored": "no storage keeps {item}: add it to the `stocks` of one",
    "plant_not_made": "no machine makes {item}: add it to the `makes` of one",
    "plant_bill": "{count} pieces do not fit into the buffer of {buffer} for {item}",
    "plant_bill_and_lot": "a cycle's {count} and a lot of {lot} do not fit into the buffer of {buffer} together",
    "plant_goods": "{count} pieces are less than the lot of {lot} of {item}: raise it",
    "plant_twice": "{name} is in this list already: put both into one line",
    "plant_id_taken": "{name} is the id of {owner} already: choose another",
    "plant_circle": "{item} is made of itself: {chain}: take one of them out of a bill",
    "plant_own_part": "{machine} makes {part}, of which {item} is made: "
    "a machine does not use what it makes; let another one make one of both",
}
"""By code, with what is filled in."""


class Reason(str):
    """A reason in English that has a code, too.

    Args:
        code: one of `TEXTS`.
        more: to be added to the English.
        values: what is filled in.
    """

    __slots__ = ("code", "values")

    code: str
    values: dict[str, str]

    def __new__(cls, code: str, more: str = "", /, **values: object) -> Self:
        """Fill it in."""
        given = {name: str(value) for name, value in values.items()}
        reason = super().__new__(cls, TEXTS[code].format_map(given) + more)
        reason.code, reason.values = code, given
        return reason
