"""Visibility: what a caller limited to areas sees of the plant.

Such a caller sees vehicles inside the areas now, machines with docks there, their transports, and what is
wrong with them. It sees a transport's way through the plant, but of its auction only the refusals with
reasons: no bids, prices or orders. A vehicle elsewhere is never named, but shown as `ELSEWHERE`. Commands
stay visible only if given to a vehicle inside the areas.
"""

from __future__ import annotations

import re
import secrets
from collections.abc import Callable, Mapping
from hashlib import blake2s
from itertools import groupby, takewhile
from typing import Any

from msgspec.structs import replace

from dray.gateway.live.places import places_of
from dray.gateway.live.plant_picture import PlantPicture
from dray.gateway.live.projection.site import Site
from dray.gateway.live.reasons import wait_text
from dray.gateway.live.views import (
    AlertView,
    AtvView,
    BriefView,
    CauseView,
    ClosureView,
    CommandView,
    MachineView,
    NewsView,
    ObstacleView,
    OpenTaskView,
    RemovalView,
    ShutOutView,
    StationView,
    TaskView,
    WaitCauseView,
    WaitView,
    WhyView,
)
from dray.gateway.live.views.alert import OF_MANY
from dray.messages.keys import GATE
from dray.plant import Plant
from dray.plant.floor.doors import doors_along
from dray.plant.model import PlantFile

Show = Callable[[Any], Any]
"""Turns a view into the form that a caller sees; None if it is not seen."""

ELSEWHERE = "*"
"""Stands for a vehicle outside the areas: its existence is seen, its name is not."""

OF_TAKEOVERS = frozenset({"took_over", "takeover_refused", "announced_anew"})
OF_VEHICLES = frozenset({"link_lost", "link_back", "help_asked", "help_promised"})
"""Kinds of news that are seen; the others are about orders."""

_WORDS = re.compile(r"\w[\w.-]*")
"""Ids in a text, including a full stop that ends the sentence."""


_GOAL = re.compile(r"O-.+\.\d+")
"""A goal of an order placed here: the order's name and the goal's position in it."""

_OF_ORDERS = re.compile(rb"(?<![\w.])O-(?:[\w-]+(?:\.\d+)+|[0-9A-Z]{9}-[0-9A-Z]{4}(?![\w-]))")
"""A goal or an order placed here, inside JSON."""

_LOST = "lost-"
"""Prefix of the names of news about lost goals."""

_SECRET = secrets.token_bytes(16)
"""Key of aliases: order names follow from the time, so an unkeyed hash could be reversed by trying all."""


def goal_alias(name: str) -> str:
    """A goal's alias for callers who may not read orders, stable in this process; other names stay."""
    return _alias("goal", name.encode()) if _GOAL.fullmatch(name) else name


def order_alias(name: str) -> str:
    """An order's alias."""
    return _alias("order", name.encode())


def words_alias(json: bytes) -> bytes:
    """A JSON document in which all goals and orders have their aliases."""
    return _OF_ORDERS.sub(
        lambda found: _alias("goal" if b"." in found[0] else "order", found[0]).encode(), json
    )


def _alias(kind: str, name: bytes) -> str:
    return f"{kind}-{blake2s(name, key=_SECRET, digest_size=8).hexdigest()}"


def news_alias(name: str) -> str:
    """The alias of a news name."""
    return _LOST + goal_alias(name.removeprefix(_LOST)) if name.startswith(_LOST) else name


class WholeVisibility:
    """Visibility of the whole plant: everything, unchanged.

    Args:
        site: the plant.
    """

    def __init__(self, site: Site) -> None:
        self._site = site

    def plant(self) -> PlantFile:
        """The plant file, with the lanes in use."""
        return self._site.plant.driven

    def atv(self, view: AtvView) -> AtvView | None:
        """A vehicle."""
        return view

    def machine(self, view: MachineView) -> MachineView | None:
        """A machine."""
        return view

    def station(self, view: StationView) -> StationView | None:
        """The station of a storage."""
        return view

    def task(self, view: TaskView) -> TaskView | None:
        """A task."""
        return view

    def alert(self, view: AlertView) -> AlertView | None:
        """What is wrong."""
        return view

    def news(self, view: NewsView) -> NewsView | None:
        """What has happened."""
        return view

    def obstacle(self, view: ObstacleView) -> ObstacleView | None:
        """What lies on a lane."""
        return view

    def wait(self, view: WaitView) -> WaitView | None:
        """A vehicle that waits."""
        return view

    def words(self, text: str) -> str:
        """Words for people."""
        return text


class FactoryVisibility(WholeVisibility):
    """Visibility of the whole plant without orders: how the factory does, not for whom.

    Goals carry the name of their order, which reveals when it was placed. They get aliases here
    (`goal_alias`).
    """

    def machine(self, view: MachineView) -> MachineView | None:
        """A machine, with aliases for its goals."""
        goals = tuple(replace(goal, goal=goal_alias(goal.goal)) for goal in view.goals)
        return replace(view, goals=goals) if goals else view

    def station(self, view: StationView) -> StationView | None:
        """The station of a storage, or the gate, with aliases for the goals to come."""
        to_come = tuple(replace(each, goal=goal_alias(each.goal)) for each in view.to_come)
        return replace(view, to_come=to_come) if to_come else view

    def task(self, view: TaskView) -> TaskView | None:
        """A task without its order."""
        stranded = view.stranded and replace(view.stranded, order="")
        return replace(view, id=goal_alias(view.id), goal=goal_alias(view.goal), order="", stranded=stranded)

    def news(self, view: NewsView) -> NewsView | None:
        """News, except about orders."""
        if view.order:
            return None
        return replace(
            view,
            id=news_alias(view.id),
            goal=goal_alias(view.goal),
            successor=goal_alias(view.successor),
            task=goal_alias(view.task),
        )

    def alert(self, view: AlertView) -> AlertView | None:
        """An alert, except about orders; one about goods comes without its order."""
        return replace(view, order="") if view.goods is not None else None if view.order else view


class AreaVisibility:
    """Visibility of some areas.

    Args:
        projection: the present plant.
        areas: ids of areas; unknown ones are empty.
    """

    def __init__(self, projection: PlantPicture, areas: frozenset[str]) -> None:
        self._projection = projection
        self._plant = plant = projection.site.plant
        self._areas = tuple(area for area in plant.areas if area in areas)
        self._here = self._within(plant)
        inside = {node.id for node in plant.nodes.values() if self.reaches(node.x_m, node.y_m)}
        self._lanes = tuple(lane for lane in plant.driven.lanes if lane.start in inside or lane.end in inside)
        # A lane across the border is seen with both of its ends.
        self._nodes = inside.union(*((lane.start, lane.end) for lane in self._lanes))

    def shows(self) -> Mapping[str, Show]:
        """By kind of entity, its form in the areas; entities of other kinds are not seen."""
        return {
            "atv": self.atv,
            "machine": self.machine,
            "station": self.station,
            "task": self.task,
            "news": self.news,
            "alert": self.alert,
            "command": self.command,
            "closure": self.closure,
            "obstacle": self.obstacle,
            "wait": self.wait,
        }

    def reaches(self, x_m: float, y_m: float) -> bool:
        """Whether a point lies in the areas."""
        return self._plant.is_in(x_m, y_m, self._areas)

    def has(self, agent: str) -> bool:
        """Whether a machine, a station, the gate or a vehicle is in the areas now."""
        if places := places_of(self._projection.site.plant, agent):
            return not self._places.isdisjoint(places)
        place_m = self._projection.atvs.place_m(agent)
        return place_m is not None and self.reaches(*place_m)

    def plant(self) -> PlantFile:
        """The part of the plant file inside the areas, with the lanes in use."""
        file, seen = self._projection.site.plant.driven, self._places
        machines = tuple(each for each in file.machines if each.id in seen)
        stations = {machine.station for machine in machines}
        return replace(
            file,
            nodes=tuple(node for node in file.nodes if node.id in self._nodes),
            lanes=self._lanes,
            warehouses=tuple(each for each in file.warehouses if each.id in seen),
            storages=tuple(each for each in file.storages if each.id in seen),
            chargers=tuple(each for each in file.chargers if each.id in seen),
            parkings=tuple(each for each in file.parkings if each.id in seen),
            machines=machines,
            stations=tuple(each for each in file.stations if each.id in stations),
            areas=tuple(each for each in file.areas if each.id in self._areas),
            doors=doors_along(file.doors, self._lanes),
            fleet=(),
        )

    def atv(self, view: AtvView) -> AtvView | None:
        """A vehicle inside the areas."""
        if not self.reaches(view.x_m, view.y_m):
            return None
        return replace(
            view,
            node=view.node if view.node in self._nodes else "",
            way=self._way(view.way),
            holds=tuple(place for place in view.holds if self._is_seen(place)),
            via=tuple(self._who(atv) for atv in view.via),
            watches=tuple(brief for brief in view.watches if self._concerned(brief)),
            dwell_point=view.dwell_point if view.dwell_point in self._places else "",
            problem=self.words(view.problem),
            body_wait=view.body_wait
            and replace(
                view.body_wait, what=self.words(view.body_wait.what), until=self.words(view.body_wait.until)
            ),
            removal=self._removal(view.removal),
            shut_out=self._shut_out(view.shut_out),
        )

    def machine(self, view: MachineView) -> MachineView | None:
        """A machine inside the areas; its goals are numbered, since their names reveal orders."""
        if view.id not in self._places:
            return None
        goals = tuple(replace(goal, goal=str(number)) for number, goal in enumerate(view.goals, 1))
        return replace(
            view,
            goals=goals,
            tasks=tuple(self._open_task(task) for task in view.tasks),
            problem=self.words(view.problem),
            shut_out=self._shut_out(view.shut_out),
        )

    def station(self, view: StationView) -> StationView | None:
        """A station inside the areas; the gate only if its people confirm arrivals by the labels, or if it has a problem."""
        if not self.has(view.id) or (view.id == GATE and view.unconfirmed is None and not view.problem):
            return None
        return replace(view, problem=self.words(view.problem), shut_out=self._shut_out(view.shut_out))

    def task(self, view: TaskView) -> TaskView | None:
        """A transport from, to or on board of something inside the areas."""
        if not self._concerns(view):
            return None
        return replace(
            view,
            primary=self._who(view.primary),
            secondary=self._who(view.secondary),
            order="",
            goal="",
            trouble=self._cause(view.trouble),
            stranded=view.stranded and replace(view.stranded, atv=self._who(view.stranded.atv), order=""),
            carriers=(),
            bids=(),
            # People who wait for it see why nobody comes; only agents inside the areas are named.
            refusals=tuple(replace(each, agent=self._who(each.agent), detail="") for each in view.refusals),
            why=WhyView(kind="unknown"),
        )

    def news(self, view: NewsView) -> NewsView | None:
        """News about agents inside the areas."""
        is_seen = self.has(view.agent)
        if is_seen and view.kind in OF_TAKEOVERS:
            return self._takeover(view)
        return replace(view, cause=self._cause(view.cause)) if is_seen and view.kind in OF_VEHICLES else None

    def alert(self, view: AlertView) -> AlertView | None:
        """An alert about something inside the areas, or that the whole plant is behind."""
        if view.kind == "plant_behind":
            return view
        if view.kind in OF_MANY:
            return self._of_many(view)
        if view.task:
            task = self._projection.tasks.view(view.task)
            if task is None or not self._concerns(task):
                return None
            return replace(view, agent=self._who(view.agent), order="", cause=self._cause(view.cause))
        if not view.agent or not self.has(view.agent):
            return None
        over = tuple(self._who(atv) for atv in view.agents)
        return replace(view, cause=self._cause(view.cause), agents=over)

    def command(self, view: CommandView) -> CommandView | None:
        """A command to a vehicle that was inside the areas when it was given."""
        was_here = not self._projection.commands.areas_of(view.id).isdisjoint(self._areas)
        return replace(view, detail=self.words(view.detail), text=self.words(view.text)) if was_here else None

    def obstacle(self, view: ObstacleView) -> ObstacleView | None:
        """An obstacle on a lane with both ends visible."""
        is_here = view.start in self._nodes and view.end in self._nodes
        return replace(view, by=self._who(view.by)) if is_here else None

    def closure(self, view: ClosureView) -> ClosureView | None:
        """A closure with a visible lane, reduced to the visible lanes."""
        lanes = tuple(lane for lane in view.lanes if lane.start in self._nodes and lane.end in self._nodes)
        if not lanes:
            return None
        cut_off = tuple(place for place in view.cut_off if place in self._places)
        unaware = tuple(atv for atv in view.not_known_by if self.has(atv))
        return replace(
            view, lanes=lanes, cut_off=cut_off, not_known_by=unaware, reason=self.words(view.reason)
        )

    def wait(self, view: WaitView) -> WaitView | None:
        """A wait of a vehicle inside the areas."""
        if not self.has(view.id):
            return None
        place, cause = view.place if self._is_seen(view.place) else "", self._wait_cause(view.cause)
        return replace(view, place=place, cause=cause, text=wait_text(cause))

    def words(self, text: str) -> str:
        """A text in which vehicles elsewhere are not named."""
        return _WORDS.sub(self._word, text) if text else text

    # --- places ---

    @property
    def _places(self) -> frozenset[str]:
        """The places inside the areas, recomputed after a machine has joined."""
        plant = self._projection.site.plant
        if plant is not self._plant:
            self._plant, self._here = plant, self._within(plant)
        return self._here

    def _within(self, plant: Plant) -> frozenset[str]:
        docks = (*plant.machines, *plant.storages, *plant.warehouses, *plant.dwell_points)
        return frozenset(place for place in docks if self.reaches(*plant.position_of(place)))

    # --- parts of views ---

    def _takeover(self, view: NewsView) -> NewsView | None:
        task = self._projection.tasks.view(view.task)
        if task is None or not self._concerns(task):
            return None
        return replace(view, other=self._who(view.other))

    def _concerns(self, task: TaskView) -> bool:
        if task.kind != "transport":
            return False
        places = {task.coordinator, task.source, task.destination, task.fails_at}
        return not self._places.isdisjoint(places) or (bool(task.primary) and self.has(task.primary))

    def _concerned(self, brief: BriefView) -> bool:
        task = self._projection.tasks.view(brief.task)
        return task is not None and self._concerns(task)

    def _open_task(self, task: OpenTaskView) -> OpenTaskView:
        return replace(
            task,
            primary=self._who(task.primary),
            secondary=self._who(task.secondary),
            trouble=self._cause(task.trouble),
        )

    def _cause(self, view: CauseView | None) -> CauseView | None:
        """A cause filtered: only its texts and its wait can name vehicles."""
        if view is None:
            return None
        wait = None if view.wait is None else self._wait_cause(view.wait)
        return replace(view, detail=self.words(view.detail), wait=wait, text=self.words(view.text))

    def _wait_cause(self, view: WaitCauseView) -> WaitCauseView:
        """A wait filtered: neighbours elsewhere in the chain become one, which hides their number."""
        place = view.place if view.place in self._places else ""
        chain = tuple(who for who, _ in groupby(self._who(atv) for atv in view.chain))
        return replace(view, chain=chain, place=place)

    def _of_many(self, view: AlertView) -> AlertView | None:
        """An alert about several agents, if one of them is inside the areas."""
        if not any(self.has(agent) for agent in view.agents):
            return None
        return replace(
            view,
            agent=self._who(view.agent),
            place=view.place if view.place in self._places else "",
            agents=tuple(self._who(agent) for agent in view.agents),
            cause=self._cause(view.cause),
        )

    def _is_seen(self, place: str) -> bool:
        """Whether a node, or the middle of a crossing, is visible."""
        crossing = self._plant.crossings.get(place)
        return place in self._nodes if crossing is None else self.reaches(crossing.x_m, crossing.y_m)

    def _removal(self, removal: RemovalView | None) -> RemovalView | None:
        """A removal with only the visible freed places, and without names of machines elsewhere."""
        if removal is None:
            return None
        freed = tuple(place for place in removal.freed if self._is_seen(place))
        node = removal.node if removal.node in self._nodes else ""
        refused = tuple(
            replace(each, agent=each.agent if each.agent in self._places else "") for each in removal.refused
        )
        return replace(removal, freed=freed, node=node, refused=refused)

    def _shut_out(self, view: ShutOutView | None) -> ShutOutView | None:
        return None if view is None else replace(view, reason=self.words(view.reason))

    def _who(self, agent: str) -> str:
        return agent if not agent or self.has(agent) else ELSEWHERE

    def _way(self, way: tuple[str, ...]) -> tuple[str, ...]:
        """The visible begin of a way."""
        return tuple(takewhile(self._nodes.__contains__, way))

    def _word(self, found: re.Match[str]) -> str:
        word = found[0]
        name = word if word in self._projection.atvs else word.rstrip(".-")
        return self._who(name) + word[len(name) :] if name in self._projection.atvs else word


Visibility = WholeVisibility | FactoryVisibility | AreaVisibility


def visibility_of(
    projection: PlantPicture, areas: frozenset[str] | None, *, orders: bool = True
) -> Visibility:
    """The visibility of a caller.

    Args:
        projection: the whole plant's picture.
        areas: ids of the caller's areas; None for the whole plant.
        orders: whether the caller may read orders; ignored with areas, which never show orders.
    """
    if areas is not None:
        return AreaVisibility(projection, areas)
    return WholeVisibility(projection.site) if orders else FactoryVisibility(projection.site)
