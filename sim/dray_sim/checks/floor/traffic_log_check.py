"""Judges from the agents' logs (`traffic_log`) whether two vehicles held one place; agents are processes of their own.

By its own messages, a vehicle holds the places that it reports, and granted places as soon as it has heard of them.
It holds a place until it says, after that grant, that it has given it back. So it never believed that it held more
than this. A killed vehicle holds its places, and its next life goes on with them. By the tables, a grant names a place
that no other vehicle held at that moment. By the floor, a vehicle drives only on lanes whose places it holds.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from statistics import median

from dray.adapters.telemetry.traffic_log import BEGUN, SAID, Line
from dray.messages import PlaceGranted, PlaceRequested
from dray.protocol.traffic.places import Places


@dataclass(slots=True)
class Wait:
    """A time for which a vehicle stood and requested a place."""

    atv: str
    begin_s: float
    end_s: float

    @property
    def waited_s(self) -> float:
        return self.end_s - self.begin_s


@dataclass(slots=True)
class Judgement:
    """The findings.

    Attributes:
        broken: violations, in words; the first hundred.
        counts: violations by kind.
        requests, grants, lanes: numbers of examined ones.
        waits: that are over.
        waiting: that are not over, by vehicle.
    """

    broken: list[str] = field(default_factory=list)
    counts: Counter[str] = field(default_factory=Counter)
    requests: int = 0
    grants: int = 0
    lanes: int = 0
    waits: list[Wait] = field(default_factory=list)
    waiting: dict[str, Wait] = field(default_factory=dict)

    @property
    def longest_s(self) -> float:
        """The longest wait, over or not."""
        return max((wait.waited_s for wait in (*self.waits, *self.waiting.values())), default=0.0)

    @property
    def median_s(self) -> float:
        """Median of the waits that are over (s)."""
        return median(wait.waited_s for wait in self.waits) if self.waits else 0.0

    def note(self, kind: str, at_s: float, words: str) -> None:
        """Something must not be."""
        self.counts[kind] += 1
        if len(self.broken) < BROKEN_KEPT:
            self.broken.append(f"{at_s:.3f}: {kind}: {words}")


BROKEN_KEPT = 100

HELD_TWICE, GRANTED_TWICE, NOT_HELD, OVERLAP = (
    "held twice",
    "granted though held",
    "driven into without holding it",
    "overlap",
)

_NO_NUMBER = 0
"""Stands for the grant of a place that a vehicle holds without one: it stood there when it joined."""


class _Vehicle:
    """The places that one vehicle holds, over all its lives."""

    def __init__(self) -> None:
        self.life = 0
        self.held: dict[str, int] = {}
        """Place -> the number of its newest grant that was heard."""
        self.seen: Counter[str] = Counter()
        """District -> the highest number that this life has heard."""
        self.epochs: Counter[str] = Counter()
        """District -> the epoch that this life knows."""
        self.wanted: dict[str, bool] = {}
        """District -> whether something is requested there."""

    def begin_life(self, life: int) -> None:
        if life > self.life:
            self.life = life
            self.seen, self.epochs, self.wanted = Counter(), Counter(), {}


class TrafficLogCheck:
    """Judges lines in the order of their times.

    Args:
        places: of the plant.
    """

    def __init__(self, places: Places) -> None:
        self.judgement = Judgement()
        self._places = places
        self._vehicles: dict[str, _Vehicle] = {}
        self._holders: dict[str, str] = {}
        self._numbers: dict[tuple[str, int], str] = {}
        """Place and number of a grant -> the vehicle."""

    def judge(self, lines: Iterable[Line]) -> Judgement:
        """Judge all lines of a run."""
        at_s = 0.0
        for line in lines:
            at_s = line.at_s
            if line.did == BEGUN:
                self._vehicles, self._holders, self._numbers = {}, {}, {}
            elif line.overlap:
                self.judgement.note(OVERLAP, at_s, f"{line.agent} and {line.overlap}")
            elif line.lane is not None:
                self._on_lane(line.agent, line.lane, at_s)
            else:
                message = line.message
                if type(message) is PlaceRequested and line.did == SAID:
                    self._on_request(line.agent, line.life, message, at_s)
                elif type(message) is PlaceGranted:
                    if line.did == SAID:
                        self._on_granting(line.other, message, at_s)
                    else:
                        self._on_granted(line.agent, line.life, line.other, message, at_s)
        for wait in self.judgement.waiting.values():
            wait.end_s = at_s
        return self.judgement

    def disagreement(self, tables: Mapping[str, Mapping[str, str]]) -> list[str]:
        """Differences between the tables' holders and the vehicles that hold places, after all lines were judged.

        Args:
            tables: district -> place -> holder, from the newest copy in the replicas' journals.
        """
        district_of = self._places.district_of
        return [
            f"{place} is held by {atv}, and by {tables[district_of[place]].get(place) or 'nobody'} in the table"
            for place, atv in sorted(self._holders.items())
            if district_of[place] in tables and tables[district_of[place]].get(place) != atv
        ]

    # --- vehicles --------------------------------------------------------------------------------

    def _of(self, atv: str, life: int) -> _Vehicle:
        vehicle = self._vehicles.setdefault(atv, _Vehicle())
        vehicle.begin_life(life)
        return vehicle

    def _on_request(self, atv: str, life: int, request: PlaceRequested, at_s: float) -> None:
        self.judgement.requests += 1
        vehicle, district = self._of(atv, life), request.district
        vehicle.epochs[district] = max(vehicle.epochs[district], request.epoch)
        for place in request.holds:
            self._take(atv, vehicle, place, vehicle.held.get(place, _NO_NUMBER), at_s)
        inside = self._places.district_of
        for place, number in tuple(vehicle.held.items()):
            if inside.get(place) == district and place not in request.holds and number <= request.seen:
                del vehicle.held[place]
                if self._holders.get(place) == atv:
                    del self._holders[place]
        self._note_wait(atv, vehicle, request, at_s)

    def _on_granted(self, atv: str, life: int, replica: str, granted: PlaceGranted, at_s: float) -> None:
        vehicle, district = self._of(atv, life), granted.district
        replicas = self._places.replicas_of.get(district, ())
        if granted.life != life or not replicas or replicas[granted.epoch % len(replicas)] != replica:
            return
        if granted.epoch < vehicle.epochs[district]:
            return
        vehicle.epochs[district] = granted.epoch
        before = vehicle.seen[district]
        for line in granted.grants:
            vehicle.seen[district] = max(vehicle.seen[district], line.number)
            if line.number > before:
                self._take(atv, vehicle, line.place, line.number, at_s)

    def _take(self, atv: str, vehicle: _Vehicle, place: str, number: int, at_s: float) -> None:
        other = self._holders.get(place, atv)
        if other != atv:
            self.judgement.note(HELD_TWICE, at_s, f"{place} by {other} and {atv}")
        self._holders[place] = atv
        vehicle.held[place] = number

    def _note_wait(self, atv: str, vehicle: _Vehicle, request: PlaceRequested, at_s: float) -> None:
        vehicle.wanted[request.district] = bool(request.groups)
        judgement = self.judgement
        if request.stands and any(vehicle.wanted.values()):
            judgement.waiting.setdefault(atv, Wait(atv, at_s, at_s))
        elif atv in judgement.waiting:
            wait = judgement.waiting.pop(atv)
            wait.end_s = at_s
            judgement.waits.append(wait)

    # --- tables -----------------------------------------------------------------------------------

    def _on_granting(self, atv: str, granted: PlaceGranted, at_s: float) -> None:
        for line in granted.grants:
            name = (line.place, line.number)
            if name not in self._numbers:
                self._numbers[name] = atv
                self.judgement.grants += 1
                other = self._holders.get(line.place, atv)
            else:
                other = self._numbers[name]
            if other != atv:
                words = f"{line.place} ({line.number}) to {atv}, and it is {other}'s"
                self.judgement.note(GRANTED_TWICE, at_s, words)

    # --- the floor -------------------------------------------------------------------------------

    def _on_lane(self, atv: str, lane: tuple[str, str], at_s: float) -> None:
        self.judgement.lanes += 1
        held = self._vehicles[atv].held if atv in self._vehicles else {}
        lacking = [place for place in self._places.needs(*lane) if place not in held]
        if lacking:
            self.judgement.note(
                NOT_HELD, at_s, f"{atv} from {lane[0]} to {lane[1]}, without {', '.join(lacking)}"
            )
