"""The profile of a vehicle type: a file that an integrator writes.

A profile tells how to talk to vehicles of one type: the version, the names of their actions, and their map's frame.
It also tells whether a way may grow during the drive, whether they can pause, and how they report loads.
Missing fields are as in `default.yaml`, which worked with nearly all.
"""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from dray.adapters.vda5050.wire.dialects import DIALECTS, Dialect, Version
from dray.adapters.vda5050.wire.orders import Value
from dray.errors import SettingsError
from dray.messages.problem import ProblemKind
from dray.plant.model import Foreign, MapFrame

DEFAULT = "default"
LARGEST_BYTES = 2**20
"""Maximum size; a profile has 2 kB, and 40 bytes for each name in it."""

NEEDED = frozenset(
    {
        *("nodeId", "edgeId", "sequenceId", "released", "nodePosition", "x", "y", "mapId", "actions"),
        *("startNodeId", "endNodeId", "actionId", "actionType", "blockingType", "actionParameters"),
    }
)
"""Mandatory fields of every order."""

Positive = Annotated[float, Meta(gt=0)]
NotNegative = Annotated[float, Meta(ge=0)]


class Item(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Base: a misspelt field is an error."""


class ActionUse(Item, frozen=True):
    """The action for one of our instructions."""

    type: Annotated[str, Meta(min_length=1)]
    """`actionType`."""
    blocking: Literal["NONE", "SOFT", "HARD"] = "HARD"
    parameters: dict[str, Value] = {}
    """Values by key. In a text {station}, {node}, {item}, {quantity} and {goal} stand for those of the instruction."""

    def values(self, **known: Value) -> dict[str, Value]:
        """The parameters of one action."""
        return {key: _filled(value, known) for key, value in self.parameters.items()}


class OwnNames(Item, frozen=True):
    """A vehicle type's own names for the plant's things, beside those of the plant file (`originals`): our name, then theirs."""

    nodes: dict[str, Foreign] = {}
    edges: dict[str, Foreign] = {}
    """Names of lanes: both nodes with two dashes between them, as `N1--N2`."""
    stations: dict[str, Foreign] = {}
    """Names of all places."""
    maps: dict[str, Foreign] = {}


class Profile(Item, frozen=True):
    """The profile of one vehicle type."""

    version: Version = "2.1"
    topics: str = ""
    """The prefix before MANUFACTURER/SERIAL; empty for the standard's suggestion."""
    instant_actions: Literal["actions", "instantActions"] = "actions"
    """The name of the list in `instantActions`: many vehicles want that of 1.1."""

    pick: ActionUse = ActionUse("pick")
    pick_by_hand: ActionUse = ActionUse("waitForTrigger", parameters={"triggerType": "manualLoading"})
    """A person loads it, at a node without a station, and confirms that on the vehicle."""
    by_hand_s: Positive = 120.0
    """Maximum wait for that person; then the order is cancelled, and its agent asks again whether anybody hands the load over."""
    drop: ActionUse = ActionUse("drop")
    charge: ActionUse = ActionUse("startCharging")
    stop_charging: str = "stopCharging"
    """The instant action before a charging vehicle drives; empty where its order is cancelled instead."""
    action_node_twice: bool = False
    """Whether an order with an action lists its node twice (sequence 0 and 2); tried anyway where an action only waits."""

    updates: bool = False
    """Whether the base may grow while it drives. Otherwise each step is an order of its own."""
    base_m: NotNegative = 0.0
    """Length of a base, which cannot be withdrawn. At least one lane."""
    trajectory: bool = True
    """Whether an edge that is not straight has its shape, as a NURBS of degree 1. Otherwise only its length: for vehicles that know the shape."""
    leave_out: tuple[str, ...] = ("trajectory", "length", "allowedDeviationXY", "allowedDeviationXy")
    """Fields of nodes and edges and parameters of actions that are left out when the vehicle reports them as unsupported. Without
    `maxSpeed` (`maximumSpeed`) it would drive faster than people allow, so that is not among them."""
    horizon: Annotated[int, Meta(ge=0, le=20)] = 0
    """Number of unreleased nodes sent beyond the base; only with `updates`."""

    pause: bool = True
    """Whether it obeys startPause and stopPause. Otherwise a stop cancels its order."""
    restart_at: Literal["last_node", "temporary_node"] = "last_node"
    """The first node of a way between two nodes: the last node, with the vehicle's position, or a node with a temporary name."""
    load: Literal["none", "any", "type"] = "any"
    """The meaning of `loads`: nothing, whether something is on board, or what (`loadType` is the item)."""

    map: MapFrame = MapFrame()
    """Its map's frame; the plant file's, where only the map's id or nothing is given."""
    maps: tuple[MapFrame, ...] = ()
    """The frames of several maps: usually one per floor."""
    names: OwnNames = OwnNames()
    node_m: Positive = 0.5
    """Maximum distance from a node at which a vehicle still stands there."""
    lane_m: Positive = 1.0
    """Maximum distance from a lane at which it is still on it."""
    deviation_m: Positive = 0.5
    """The allowed deviation at a node of an order."""
    first_deviation_m: Positive = 1.0
    """The allowed deviation at the first one, where it stands already."""

    problems: dict[str, ProblemKind] = {}
    """The kind of problem by the vehicle's `errorType`; other types are guessed from words in them."""

    kept_until_order: tuple[str, ...] = ()
    """`errorType`s at FATAL that the vehicle shows until its next order, and that block none: as CRITICAL ones of 3.0."""

    state_every_s: Positive = 30.0
    """Maximum seconds between states; 30 s is the standard's."""
    resend_s: Positive = 2.0
    """Seconds before an order or instant action is sent again."""
    silent_s: Positive = 10.0
    """Seconds after which an order that is not shown counts as silently refused."""
    waiting_s: Positive = 15.0
    """Seconds of only waiting after which an action is retried."""
    acting_s: Positive = 300.0
    """Seconds after which a pick or drop that has not ended is a problem."""
    tries: Annotated[int, Meta(ge=1, le=20)] = 4
    """Maximum offers of one order, each under another id."""
    battery_scale: Literal["percent", "fraction"] = "percent"
    """Whether its battery counts to 100, as in the standard, or to 1."""
    full_percent: Annotated[float, Meta(gt=0, le=100)] = 99.0
    """The level from which a battery is full."""

    @property
    def dialect(self) -> Dialect:
        """Its version's dialect."""
        return DIALECTS[self.version]

    def topic(self, manufacturer: str, serial: str, name: str) -> str:
        """The topic of a kind of message."""
        return f"{self.topics or self.dialect.prefix}/{manufacturer}/{serial}/{name}"


def shipped_profiles() -> tuple[str, ...]:
    """The names of the profiles in the package."""
    folder = files("dray.adapters.vda5050") / "profiles"
    return tuple(
        sorted(file.name.removesuffix(".yaml") for file in folder.iterdir() if file.name.endswith(".yaml"))
    )


def load_profile(name: str) -> Profile:
    """Read a profile.

    Args:
        name: a YAML file, or the name of one in the package; a file takes precedence.

    Raises:
        SettingsError: there is none, or it cannot be used; names the place.
    """
    file = Path(name)
    try:
        if file.is_file():
            data = file.read_bytes()
        elif name in shipped_profiles():
            data = (files("dray.adapters.vda5050") / "profiles" / f"{name}.yaml").read_bytes()
        else:
            known = ", ".join(shipped_profiles())
            raise SettingsError(
                "--profile", f"there is no file {name}, and no profile of that name among {known}"
            )
    except OSError as error:
        raise SettingsError("--profile", f"{name} cannot be read: {error.strerror}") from None
    if len(data) > LARGEST_BYTES:
        raise SettingsError("--profile", f"{name} has more than {LARGEST_BYTES} bytes: that is another file")
    return parse_profile(data, name)


def parse_profile(data: bytes, name: str) -> Profile:
    """A profile from YAML; see `load_profile`.

    Raises:
        SettingsError: it cannot be used.
    """
    try:
        # An empty file has nothing but defaults.
        said = msgspec.yaml.decode(data) or {}
        profile = msgspec.convert(said, Profile)
    except (msgspec.DecodeError, msgspec.ValidationError, UnicodeDecodeError) as error:
        raise SettingsError("--profile", f"{name}: {error}") from None
    if profile.horizon and not profile.updates:
        raise SettingsError(
            "--profile", f"{name}: horizon: a vehicle without updates never drives it; set updates"
        )
    if needed := sorted(NEEDED.intersection(profile.leave_out)):
        raise SettingsError("--profile", f"{name}: leave_out: no order is one without {', '.join(needed)}")
    for use in (profile.pick, profile.pick_by_hand, profile.drop, profile.charge):
        try:
            use.values(station="", node="", item="", quantity=0, goal="")
        except (KeyError, ValueError, IndexError) as error:
            raise SettingsError("--profile", f"{name}: {use.type}: no parameter can be {error}") from None
    return profile


def write_profile(profile: Profile) -> str:
    """A profile as YAML: only its differences from the default."""
    plain = msgspec.to_builtins(Profile())
    said = {key: value for key, value in msgspec.to_builtins(profile).items() if plain[key] != value}
    return msgspec.yaml.encode(said).decode() if said else "{}\n"


def _filled(value: Value, known: dict[str, Value]) -> Value:
    if isinstance(value, tuple):
        return tuple(str(_filled(each, known)) for each in value)
    if not isinstance(value, str):
        return value
    # A value that consists of one name keeps its type: a quantity stays a number.
    if value.startswith("{") and value.endswith("}") and value[1:-1] in known:
        return known[value[1:-1]]
    return value.format(**known)
