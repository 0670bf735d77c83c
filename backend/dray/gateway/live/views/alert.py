"""What asks for an answer: alerts and their conditions."""

from __future__ import annotations

from hashlib import blake2s
from typing import Literal

from dray.gateway.live.views.base import View
from dray.gateway.live.views.cause import CauseView
from dray.gateway.live.views.load import DoubtView

AlertKind = Literal[
    "plant_behind",
    "no_strategist",
    "part_lost",
    "machine_lost",
    "machine_error",
    "station_lost",
    "gate_lost",
    "gate_error",
    "atv_lost",
    "atv_awaited",
    "atv_unplaced",
    "atv_unheard",
    "call_nobody",
    "call_unanswered",
    "atv_help",
    "atv_error",
    "jam",
    "order_impossible",
    "order_waits",
    "order_late",
    "overloaded",
    "machine_shut_out",
    "station_shut_out",
    "atv_shut_out",
    "strategist_lost",
    "machine_document",
    "machine_starved",
    "machine_blocked",
    "dock_fails",
    "dock_not_ready",
    "stock_unknown",
    "load_doubtful",
    "handover_disputed",
    "clock_wrong",
    "word_disbelieved",
    "strangers",
    "goods_stranded",
    "task_trouble",
    "atv_waits",
    "atv_promised",
    "atv_stopped",
    "atv_battery",
    "access_point",
    "atv_mesh",
]
"""Kinds of troubles; graver kinds first."""

OF_MANY: frozenset[AlertKind] = frozenset(("jam", "access_point", "part_lost"))
"""Kinds whose alert covers several agents."""

CallKind = Literal["call_nobody", "call_unanswered"]
"""Why nobody comes: nobody is on duty there, or nobody asked has taken the call."""

AlertResponse = Literal[
    "look_at_server",
    "add_vehicles",
    "look_at_part",
    "look_at_machine",
    "look_at_station",
    "look_at_gate",
    "see_to_gate",
    "look_at_strategist",
    "repair",
    "see_to_supply",
    "put_document_right",
    "see_to_removal",
    "see_to_dock",
    "count_stock",
    "find_vehicle",
    "switch_on",
    "see_to_place",
    "shut_out_and_clear",
    "put_right_and_readmit",
    "promise_help",
    "help",
    "resume",
    "bring_to_charger",
    "look_at_auction",
    "cancel_order",
    "restore_machines",
    "tell_customer",
    "check_vehicle",
    "set_clock",
    "look_at_network",
    "clear_way",
    "repair_link",
    "repair_access_point",
    "send_somebody",
    "see_to_goods",
]
"""The response that an alert asks of people."""


class GoodsView(View, kw_only=True):
    """Goods on board of a failed vehicle that wait for a person."""

    item: str
    name: str
    """Name of the product."""
    quantity: int
    machine: str
    """The machine that made them, and makes them again if they are lost."""
    order_name: str = ""
    """Name of their order, as in `StrandedView.order_name`."""
    node: str = ""
    """Node where the vehicle was heard last; empty if unknown."""
    handed_at: str = ""
    """Place where a person hands them over to another vehicle; empty while nobody has said so."""


class Condition(View, kw_only=True):
    """A present trouble and its details."""

    kind: AlertKind
    agent: str = ""
    """The machine, storage or vehicle concerned; for a transport, its carrier, or the place where carriers fail.
    Empty for an order and for the plant as a whole."""
    task: str = ""
    order: str = ""
    place: str = ""
    """For a jam before a dock: the place of that dock."""
    agents: tuple[str, ...] = ()
    """The agents concerned. For a jam: all that wait, longest wait first. For a vehicle without WLAN: the
    relays of its messages, in order. For an access point or a part of the network: all that lost it, by name.
    For strategists: the silent ones. For a dock that does not get ready: the vehicle that waits."""
    call: CallKind | None = None
    """For a call for help in vain: why nobody comes."""
    keepers: tuple[str, ...] = ()
    """For an awaited vehicle: machines and storages that grant no places before it has reported its
    reservations."""
    cause: CauseView | None = None
    """The cause, if known."""
    goods: GoodsView | None = None
    """For goods left on board: their details."""
    doubt: DoubtView | None = None
    """For a load that may lie at a place although it is not in its stock."""
    by: str = ""
    """Person on the way to help, or who has shut the agent out. For goods: the operator who comes, by name or
    code."""
    seen_at_s: float | None = None
    """For a lost agent: when it was last heard; for several, the first of them. For a call for help, a lost
    WLAN or a dock that does not get ready: since when."""
    access_point: str = ""
    """Last access point of vehicles without WLAN; empty if unknown."""
    until_at_s: float | None = None
    """End of the wait for help, or due time of the order. For goods: when they are given up and made
    again."""
    battery_frac: float | None = None
    behind_s: float | None = None
    """Age of the plant's newest message, in real seconds."""
    waiting: int | None = None
    """Number of transports that have waited for a vehicle for more than 5 factory minutes."""
    carried_frac: float | None = None
    """Fraction of the last factory hour's transports that were carried; None before any."""
    clock_ahead_s: float | None = None
    """For a wrong clock: seconds ahead, negative if behind (factory seconds)."""

    @property
    def alert(self) -> str:
        """The id of its alert: stable while the same trouble of the same subject lasts."""
        subject = self.task or self.order or self.agent if self.doubt is None else self.doubt.load
        if self.kind == "access_point":
            subject = self.access_point
        elif self.kind in OF_MANY:
            # The id must not name a vehicle to viewers limited to other areas.
            first = (subject or self.agents[0]).encode()
            subject = self.place or blake2s(first, digest_size=4).hexdigest()
        return f"{self.kind}-{subject}" if subject else self.kind


class AlertView(Condition, kw_only=True):
    """A condition, and what it asks of people. It leaves when its cause is gone."""

    id: str
    level: Literal["alarm", "warning"]
    response: AlertResponse
    since_at_s: float
    acknowledged_by: str = ""
    """Name of the person who has taken it on; empty while nobody has."""
    acknowledged_at_s: float | None = None
    acknowledged_until_at_s: float | None = None
    """End of the acknowledgement; None for as long as the alert lasts. Then it asks again, and sooner when it
    is worse."""
    came_back: Literal["over", "worse"] | None = None
    """Why an alert taken on until a set time asks again: the time is over, or it is worse."""
    comment: str = ""
    """The last comment on it."""
    comment_by: str = ""


class AlertWordView(View, kw_only=True):
    """One entry in an alert's history."""

    at_s: float
    by: str = ""
    """The person; empty where it came back by itself."""
    said: Literal["taken", "commented", "over", "worse"]
    """Taken on or commented; or it asked again, because its time was over or it became worse."""
    comment: str = ""
    until_at_s: float | None = None
    """End of the acknowledgement; None for as long as the alert lasts."""


class AlertRecord(AlertView, kw_only=True):
    """A past or present alert."""

    number: int
    ended_at_s: float | None = None
    """None while it lasts."""
    reference: str | None = None
    """For an order: the customer's own number of it."""
    words: tuple[AlertWordView, ...] = ()
    """Oldest first."""
