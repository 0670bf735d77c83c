"""The behaviour of an insider as data: another lie is another line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

SILENT_S = 10.0
"""Just longer than anybody waits for a vehicle at work: the sooner it is back, the more it takes."""

SINCE_1970_S = 1.8e9
"""Error of a clock that has lost its battery: unix time begins at zero."""


class Price(Enum):
    """The price in its bids."""

    NOTHING = "nothing"
    """Zero, and to be done at once."""
    ABSURD = "absurd"
    """A price as far below zero as a message can hold."""
    LEAST = "least"
    """The least price of a vehicle that stands at the source already: it is not recognisable as a lie."""


class Answer(Enum):
    """Its answer to an award."""

    ACCEPT = "accept"
    DECLINE = "decline"
    RESIGN = "resign"
    """Accept, and give the contract back at once."""
    NONE = "none"


@dataclass(frozen=True, slots=True)
class Behaviour:
    """The behaviour of one insider.

    One that `drives` is an honest vehicle except for the fields below; the others never move.

    Attributes:
        name: in reports.
        shows: in one line.
        drives: it has the software of a vehicle, and a body.
        price: of its bids; None for no bids.
        answers: to an award.
        silent_s: silence after every task that it has got.
        boasts: it reports the load of every task as on board at once.
        pretends: it reports ways and phases as if it worked at each of its tasks.
        hands_over: it reports handovers of loads that it never had.
        claims_all: it claims every charger and parking place, as if it stood there.
        claims_floor: it says to all replicas of reservation tables that it holds every place, and wants every place.
        takes_name: it has stolen the certificate of a vehicle of the plant, whose owner lives, and in its name gives
            all its places back.
        has_key: it has stolen the vehicle's key with its certificate (its disk). In the vehicle's name it repeats its
            messages under numbers that the vehicle has not reached yet.
        takes_replica: it has stolen the certificate of a replica of reservation tables, whose owner lives, and claims other replicas'
            tables.
        leads_falsely: it has stolen the certificate of a replica that leads reservation tables, and grants places that are held by
            other vehicles.
        names_others: it reports tasks of other carriers as its own.
        flood_hz: messages per second to all coordinators in turn.
        betrays_every: it betrays one of so many tasks that it has taken: it says that all is well, and stands.
        keeps_loads: it fetches the load of a betrayed task first, and never puts it down.
        says_down: it reports the load of a betrayed task as put down, and keeps it.
        speed_frac: its speed as a part of the speed that it bids with.
        bodiless: its software has no body: every instruction counts as done, and nothing moves.
        clock_ahead_s: error of its computer's clock; negative for behind.
    """

    name: str
    shows: str
    drives: bool = False
    price: Price | None = None
    answers: Answer = Answer.ACCEPT
    silent_s: float = 0.0
    boasts: bool = False
    pretends: bool = False
    hands_over: bool = False
    claims_all: bool = False
    claims_floor: bool = False
    takes_name: bool = False
    has_key: bool = False
    takes_replica: bool = False
    leads_falsely: bool = False
    names_others: bool = False
    flood_hz: float = 0.0
    betrays_every: int = 0
    keeps_loads: bool = False
    says_down: bool = False
    speed_frac: float = 1.0
    bodiless: bool = False
    clock_ahead_s: float = 0.0

    @property
    def is_thief(self) -> bool:
        """Whether it speaks in the name of an agent of the plant, for whom it must change nothing."""
        return self.takes_name or self.takes_replica or self.leads_falsely


_ALL = (
    Behaviour(
        "bids-nothing", "bids 0, accepts everything, names its tasks, never moves", price=Price.NOTHING
    ),
    Behaviour("bids-absurdly", "the same with bids of -1e11 s", price=Price.ABSURD),
    Behaviour("bids-the-least", "the same with the least bids that can be true", price=Price.LEAST),
    Behaviour(
        "pretends",
        "the same, and tells of ways and phases as if it drove",
        price=Price.LEAST,
        pretends=True,
    ),
    Behaviour(
        "falls-silent",
        "bids 0, accepts, and falls silent, again and again",
        price=Price.NOTHING,
        silent_s=SILENT_S,
    ),
    Behaviour(
        "falls-silent-loaded",
        "the same with the least bids that can be true, and says before that it has the load on board",
        price=Price.LEAST,
        silent_s=SILENT_S,
        boasts=True,
    ),
    Behaviour("declines", "bids, and declines every award", price=Price.LEAST, answers=Answer.DECLINE),
    Behaviour("never-answers", "bids, and answers no award", price=Price.LEAST, answers=Answer.NONE),
    Behaviour("resigns", "accepts, and gives back at once", price=Price.LEAST, answers=Answer.RESIGN),
    Behaviour(
        "hands-over-nothing",
        "says that loads are down which it never had",
        price=Price.LEAST,
        pretends=True,
        hands_over=True,
    ),
    Behaviour("claims-dwell-points", "claims every charger and parking place", claims_all=True),
    Behaviour(
        "claims-the-floor",
        "says to all replicas of reservation tables that it holds every place, and wants every place",
        claims_floor=True,
    ),
    Behaviour(
        "speaks-in-anothers-name",
        "says to all replicas of reservation tables, with a stolen certificate, that a vehicle gives back all that it holds",
        takes_name=True,
    ),
    Behaviour(
        "doubles-a-vehicle",
        "says to all replicas of reservation tables, with a stolen certificate and its vehicle's key, what the vehicle says, and is ahead of it",
        takes_name=True,
        has_key=True,
    ),
    Behaviour(
        "usurps-books",
        "says to replicas and vehicles, with a replica's stolen certificate, that it keeps the reservation tables of others, and grants every place",
        takes_replica=True,
    ),
    Behaviour(
        "leads-falsely",
        "grants every place, with the stolen certificate of the replicas that lead the tables, under their present epochs",
        leads_falsely=True,
    ),
    Behaviour("names-others-tasks", "names as its own what others carry", names_others=True),
    Behaviour("floods", "sends 20 messages a second to the coordinators", price=Price.LEAST, flood_hz=20.0),
    Behaviour(
        "always-late",
        "drives at a fifth of the speed that it bids with",
        drives=True,
        price=Price.LEAST,
        speed_frac=0.2,
    ),
    Behaviour(
        "betrays",
        "does three tasks well, and stands in the fourth",
        drives=True,
        price=Price.LEAST,
        betrays_every=4,
    ),
    Behaviour(
        "keeps-loads",
        "does three tasks well, and never puts the fourth load down",
        drives=True,
        price=Price.LEAST,
        betrays_every=4,
        keeps_loads=True,
    ),
    Behaviour(
        "says-down-and-keeps",
        "does three tasks well, and says of the fourth load that it is down",
        drives=True,
        price=Price.LEAST,
        betrays_every=4,
        keeps_loads=True,
        says_down=True,
    ),
    Behaviour(
        "no-body",
        "honest software without a body: says that it loads, drives and unloads, and nothing moves",
        price=Price.LEAST,
        bodiless=True,
    ),
    Behaviour(
        "clock-of-1970",
        "an honest vehicle whose clock begins at zero",
        drives=True,
        clock_ahead_s=-SINCE_1970_S,
    ),
    Behaviour(
        "clock-an-hour-ahead",
        "an honest vehicle whose clock is an hour ahead",
        drives=True,
        clock_ahead_s=3600.0,
    ),
)

BEHAVIOURS: Mapping[str, Behaviour] = {behaviour.name: behaviour for behaviour in _ALL}
"""Behaviours by name, in the order of the table."""
