"""What asks for an answer."""

from __future__ import annotations

from hashlib import blake2s
from typing import Literal

from dray.gateway.live.views.base import View
from dray.gateway.live.views.cause import CauseView

AlertKind = Literal[
    "plant_behind",
    "no_strategist",
    "part_lost",
    "machine_lost",
    "machine_error",
    "station_lost",
    "gate_lost",
    "atv_lost",
    "atv_awaited",
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
    "dock_not_ready",
    "stock_unknown",
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
"""What can be wrong; graver kinds first."""

OF_MANY: frozenset[AlertKind] = frozenset(("jam", "access_point", "part_lost"))
"""Kinds that tell of all their agents at once."""

CallKind = Literal["call_nobody", "call_unanswered"]
"""Why nobody comes: nobody is on duty there, or nobody who was asked has taken the call."""

AlertResponse = Literal[
    "look_at_server",
    "add_vehicles",
    "look_at_part",
    "look_at_machine",
    "look_at_station",
    "look_at_gate",
    "look_at_strategist",
    "repair",
    "see_to_supply",
    "put_document_right",
    "see_to_removal",
    "see_to_dock",
    "count_stock",
    "find_vehicle",
    "switch_on",
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
"""What an alert asks of people."""


class GoodsView(View, kw_only=True):
    """Goods that a failed vehicle has on board, and that wait for a person."""

    item: str
    name: str
    """Of the product."""
    quantity: int
    machine: str
    """Whose they are: it makes them again."""
    order_name: str = ""
    """For which order, as `StrandedView.order_name`."""
    node: str = ""
    """Where the vehicle was heard last; empty where nobody knows."""
    handed_at: str = ""
    """Where a person hands them over, and another vehicle comes for them; empty while nobody has said so."""


class Condition(View, kw_only=True):
    """Something that is wrong now, and what is known of it."""

    kind: AlertKind
    agent: str = ""
    """The machine, storage or vehicle that it is about; of a transport, who carries it. Empty for an order, and for the plant as a
    whole."""
    task: str = ""
    order: str = ""
    place: str = ""
    """Of a jam before a dock: whose dock that is."""
    agents: tuple[str, ...] = ()
    """Of a jam: all that wait in it, who has waited longest first. Of a vehicle without WLAN: those over which it is heard, in order.
    Of an access point and of a part of the network: all that have lost it, by name. Of strategists: those that are silent. Of a dock that does not get ready: who waits for it."""
    call: CallKind | None = None
    """Of who has called for help in vain: why nobody comes."""
    keepers: tuple[str, ...] = ()
    """Of a vehicle that is awaited: the machines and storages that grant no places before it has told what it holds."""
    cause: CauseView | None = None
    """What is known of why."""
    goods: GoodsView | None = None
    """Of goods that were left on board."""
    by: str = ""
    """Who is on the way to help, or has shut the agent out. Of goods: the operator who comes, by name or code."""
    seen_at_s: float | None = None
    """Of who is lost: when it was last heard, of many the first of them. Of a call for help, without WLAN, or of
    a dock that does not get ready: since when."""
    access_point: str = ""
    """Over which vehicles without WLAN were on it last; empty where that is not known."""
    until_at_s: float | None = None
    """How long help is waited for, or when the order was due. Of goods: when they are given up, and made again."""
    battery_frac: float | None = None
    behind_s: float | None = None
    """How old the newest is that was heard of the plant, in real seconds."""
    waiting: int | None = None
    """Transports that have waited for a vehicle for longer than 5 factory minutes."""
    carried_frac: float | None = None
    """Part of the last factory hour's transports that were carried; None before any."""
    clock_ahead_s: float | None = None
    """Of a wrong clock: how far it is ahead, behind if below 0 (factory seconds)."""

    @property
    def alert(self) -> str:
        """The id of its alert: the same one as long as the same thing is wrong with the same subject."""
        subject = self.task or self.order or self.agent
        if self.kind == "access_point":
            subject = self.access_point
        elif self.kind in OF_MANY:
            # Whoever sees only a part of it is not told by its name who is elsewhere.
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
    """The name of who has taken it on; empty while nobody has."""
    acknowledged_at_s: float | None = None
    acknowledged_until_at_s: float | None = None
    """Until when; None for as long as it lasts. Then it asks again, and sooner when it is worse."""
    came_back: Literal["over", "worse"] | None = None
    """Why it asks again, of an alert that somebody had taken on until some moment: the time is over, or it is worse."""
    comment: str = ""
    """What was said of it last."""
    comment_by: str = ""


class AlertWordView(View, kw_only=True):
    """What was done with an alert."""

    at_s: float
    by: str = ""
    """Whose word it is; empty where it came back by itself."""
    said: Literal["taken", "commented", "over", "worse"]
    """Taken on, or something said of it; or it asked again, since the time was over or it had become worse."""
    comment: str = ""
    until_at_s: float | None = None
    """Until when it was taken on; None for as long as it lasts."""


class AlertRecord(AlertView, kw_only=True):
    """An alert that there was, or is."""

    number: int
    ended_at_s: float | None = None
    """None while it lasts."""
    reference: str | None = None
    """Of an order: the customer's own number of it."""
    words: tuple[AlertWordView, ...] = ()
    """Oldest first."""
