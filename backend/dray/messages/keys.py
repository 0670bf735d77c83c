"""Keys on the bus, and the agents that own them.

Keys are paths of chunks, as in Zenoh: ``*`` stands for one chunk, ``**`` for any number of them, and only subscriptions may hold
these. No wildcard matches a chunk that begins with ``@``. An id never holds any of these.

    {plant}/hb/atv/{id}       heartbeats of a vehicle
    {plant}/hb/machine/{id}   heartbeats of a machine
    {plant}/hb/station/{id}   heartbeats of a storage's station, and of the delivery gate
    {plant}/hb/strategist/{id}  heartbeats of a strategist, where there are several
    {plant}/hb/operator/{id}  heartbeats of an operator on duty
    {plant}/call/{id}         an agent's call for help: the operators asked, and the one who comes
    {plant}/task/{cell}       announcements of transports, to the grid cells within the radius
    {plant}/goal/{product}    announcements of production goals, to the machines that were set up for it
    {plant}/goal/{machine}    those of other products, to a machine that can make them by their definition
    {plant}/dwell-point/{id}  claims of one charger or parking place
    {plant}/free/{id}         a free vehicle's question for waiting work
    {plant}/dock/{place}      when vehicles will be at the dock of a place, to the place's coordinators
    {plant}/problem/{id}      how long a vehicle's problem has lasted, when it is over
    {plant}/obstacle/{id}     an obstacle that a vehicle has met on a lane, and its end, also as a person's report
    {plant}/breakdown/{id}    how long a machine's problem has lasted, when it is over
    {plant}/agent/@{id}       messages to one agent alone
    {plant}/event/{id}        an agent's numbered events
    {plant}/shut-out          the agents that are shut out, repeated by gateways
    {plant}/closures          closures to vehicles, repeated by gateways
    {plant}/floor/{district}  the vehicles that hold places in a district, to those that drive there or nearby
    {plant}/removals          vehicles that people have carried away, or are putting back, repeated by gateways
    {plant}/alive/{id}/{life}/{seal}  a token that exists as long as this life of the agent
"""

from __future__ import annotations

from functools import lru_cache

STRATEGIST = "strategist"
"""The strategist's id in a plant with one."""


def strategists_of(count: int) -> tuple[str, ...]:
    """The ids of this number of strategists."""
    return (STRATEGIST, *(f"{STRATEGIST}{number}" for number in range(2, count + 1)))


GATE = "gate"
"""The id of the gate of the delivery warehouses, one agent in every plant."""

HISTORIAN = "historian"
"""The historian's name on the bus."""

STRATEGISTS = frozenset(strategists_of(9))
"""The ids of strategists: no plant may use them for a machine, a storage or a vehicle."""


class Keys:
    """The keys of one plant.

    Args:
        plant: the plant's id; it is the first chunk of every key.
    """

    __slots__ = (
        "_addressed",
        "alive",
        "all_atv_heartbeats",
        "all_breakdowns",
        "all_calls",
        "all_events",
        "all_floors",
        "all_free",
        "all_heartbeats",
        "all_machine_heartbeats",
        "all_obstacles",
        "all_operator_heartbeats",
        "all_problems",
        "all_station_heartbeats",
        "all_strategist_heartbeats",
        "closures",
        "plant",
        "removals",
        "shut_out",
    )

    def __init__(self, plant: str) -> None:
        self.plant = plant
        self.all_heartbeats = f"{plant}/hb/**"
        self.all_atv_heartbeats = f"{plant}/hb/atv/*"
        self.all_machine_heartbeats = f"{plant}/hb/machine/*"
        self.all_station_heartbeats = f"{plant}/hb/station/*"
        self.all_strategist_heartbeats = f"{plant}/hb/strategist/*"
        self.all_operator_heartbeats = f"{plant}/hb/operator/*"
        self.all_calls = f"{plant}/call/*"
        self.all_events = f"{plant}/event/*"
        self.all_free = f"{plant}/free/*"
        self.all_problems = f"{plant}/problem/*"
        self.all_breakdowns = f"{plant}/breakdown/*"
        self.all_floors = f"{plant}/floor/*"
        self.all_obstacles = f"{plant}/obstacle/*"
        self.shut_out = f"{plant}/shut-out"
        self.closures = f"{plant}/closures"
        self.removals = f"{plant}/removals"
        self.alive = f"{plant}/alive"
        self._addressed = f"{plant}/agent/@"

    def atv_heartbeat(self, atv: str) -> str:
        return f"{self.plant}/hb/atv/{atv}"

    def machine_heartbeat(self, machine: str) -> str:
        return f"{self.plant}/hb/machine/{machine}"

    def station_heartbeat(self, station: str) -> str:
        return f"{self.plant}/hb/station/{station}"

    def strategist_heartbeat(self, strategist: str) -> str:
        return f"{self.plant}/hb/strategist/{strategist}"

    def operator_heartbeat(self, operator: str) -> str:
        return f"{self.plant}/hb/operator/{operator}"

    def call(self, caller: str) -> str:
        return f"{self.plant}/call/{caller}"

    def transports(self, cell: str) -> str:
        return f"{self.plant}/task/{cell}"

    def goals(self, product_or_machine: str) -> str:
        return f"{self.plant}/goal/{product_or_machine}"

    def dwell_point(self, dwell_point: str) -> str:
        return f"{self.plant}/dwell-point/{dwell_point}"

    def free(self, atv: str) -> str:
        return f"{self.plant}/free/{atv}"

    def dock(self, place: str) -> str:
        return f"{self.plant}/dock/{place}"

    def problem(self, atv: str) -> str:
        return f"{self.plant}/problem/{atv}"

    def obstacle(self, agent: str) -> str:
        return f"{self.plant}/obstacle/{agent}"

    def breakdown(self, machine: str) -> str:
        return f"{self.plant}/breakdown/{machine}"

    def floor(self, district: str) -> str:
        return f"{self.plant}/floor/{district}"

    def addressed(self, agent: str) -> str:
        return f"{self._addressed}{agent}"

    def addressee(self, key: str) -> str:
        """The one agent that messages on `key` are for; empty when they are for all listeners."""
        prefix = self._addressed
        return key[len(prefix) :] if key.startswith(prefix) else ""

    def events(self, agent: str) -> str:
        return f"{self.plant}/event/{agent}"


_OWNED = frozenset(
    {
        "hb/atv",
        "hb/machine",
        "hb/station",
        "hb/strategist",
        "hb/operator",
        "event",
        "free",
        "problem",
        "breakdown",
        "call",
        "obstacle",
    }
)


@lru_cache(maxsize=4096)
def owner_of(key: str) -> str | None:
    """The only agent that may speak on `key`, in any plant; None when others may, too."""
    start, _, last = key.partition("/")[2].rpartition("/")
    return last if start in _OWNED else None
