"""People's commands as panels see them."""

from __future__ import annotations

from typing import Literal

from dray.gateway.live.views.base import View

CommandState = Literal["sent", "confirmed", "refused", "not_confirmed"]


class CommandView(View, kw_only=True):
    """A person's command to a vehicle, machine or station, and its answer."""

    id: str
    """Given by the sender, else by the gateway."""
    atv: str
    """The addressee: a vehicle, machine or station."""
    kind: Literal[
        "stop",
        "acknowledge",
        "resume",
        "set_speed",
        "promise",
        "hand_over",
        "charge",
        "take_out",
        "put_in",
        "clear_fault",
        "restart",
        "update",
        "fetch_goods",
        "write_off",
        "load_there",
        "load_missing",
        "arrived",
        "taken",
        "made",
        "scrapped",
        "stock_is",
    ]
    speed_frac: float | None = None
    by: str
    """Name of the person who gave it."""
    at_s: float
    """When it was given."""
    state: CommandState = "sent"
    """not_confirmed: no answer in time; it may or may not have arrived."""
    reason: str = ""
    """Reason of a refusal: a `CommandRefusal` of the wire; empty if there is none, or another part refused
    it."""
    detail: str = ""
    """What its sensors still report, or why its answer is not awaited."""
    text: str = ""
    """Reason and detail in English."""
