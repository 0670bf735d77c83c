"""People's commands as panels see them."""

from __future__ import annotations

from typing import Literal

from dray.gateway.live.views.base import View

CommandState = Literal["sent", "confirmed", "refused", "not_confirmed"]


class CommandView(View, kw_only=True):
    """What a person has asked of a vehicle, a machine or a station, and its word on it."""

    id: str
    """As whoever gave it has named it, else as the gateway has."""
    atv: str
    """Whom it was given to: a vehicle, a machine, or a station."""
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
    """The name of who gave it."""
    at_s: float
    """When."""
    state: CommandState = "sent"
    """not_confirmed: it has said nothing in time; it may or may not have heard."""
    reason: str = ""
    """Why it was refused: a `CommandRefusal` of the wire; empty where it has not, or somebody else has."""
    detail: str = ""
    """What its sensors still report, or why nobody waits for its word."""
    text: str = ""
    """Both in English."""
