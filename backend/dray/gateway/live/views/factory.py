"""The factory as a whole, the stream's reader, and injected faults."""

from __future__ import annotations

from typing import Any, Literal

import msgspec

from dray.gateway.live.views.base import View
from dray.scenario_steps import ScenarioStep


class AudienceView(View, kw_only=True):
    """The reader of the stream, and how much of it is shown."""

    role: Literal["manager", "operator", ""]
    """Empty for other systems and the administrator."""
    name: str
    areas: tuple[str, ...] | None = None
    """Areas to which the stream is limited; None for the whole plant."""
    station: str = ""
    """The machine at which an operator works."""


class FaultView(View, kw_only=True):
    """A fault that was begun by hand in a simulated factory, and has not ended."""

    id: str
    kind: str
    fault: dict[str, Any]
    """The fault as it was begun: its `kind` and its fields."""
    agents: tuple[str, ...]
    """Agents concerned; empty where it concerns the whole network."""
    began_at_s: float


class StepView(View, kw_only=True):
    """A step of a scenario."""

    step: ScenarioStep
    after_s: float | None = None
    """Factory seconds from the scenario's begin; None until it happens."""
    expected_s: float | None = None
    """Expected `after_s`, by a rehearsal with the same seed, shifted by the last step's delay; None until the
    rehearsal gets there."""
    agents: tuple[str, ...] = ()
    """Agents concerned."""


class ScenarioCheckView(View, kw_only=True):
    """One check of a scenario's claim."""

    name: str
    """In English."""
    held: bool
    figure: str
    """The observed figure, in English."""


class ScenarioView(View, kw_only=True):
    """The scenario that a simulated factory plays, step by step."""

    id: str
    """Id as in `dray up --scenario`."""
    shows: str
    """What it shows, in English."""
    steps: tuple[StepView, ...]
    """In the expected order."""
    state: Literal["playing", "held", "failed"] = "playing"
    """Whether its claim has held, once it has ended."""
    after_s: float | None = None
    """Factory seconds from begin to end."""
    checks: tuple[ScenarioCheckView, ...] = ()
    """The checks, once it has ended."""
    began_at_s: float = 0.0
    """Wall clock."""
    skipping: bool = False
    """Whether the factory runs as fast as it can until the next step."""


class UseView(View, kw_only=True):
    """How the fleet spent the last hour, in fractions that add up to 1."""

    moving: float
    waiting: float
    """At work but standing: loading, unloading, or without a way."""
    charging: float
    blocked: float
    """Stopped by a person, or in error."""
    idle: float
    silent: float
    """Silent for more than three heartbeat intervals of an idle agent."""
    out_of_service: float = 0.0
    """By a person's word."""


class FactoryView(View, kw_only=True):
    """The factory as a whole."""

    orders_open: int = 0
    orders_delivered: int = 0
    on_time_frac: float | None = None
    """Fraction of all delivered orders; None before the first."""
    starved_frac: float | None = None
    """Fraction of the machines' time with a goal in the last hour in which material was missing."""
    transport_p50_s: float | None = None
    """From announcement to handover, over the last 200 transports, in factory seconds."""
    transport_p95_s: float | None = None
    empty_frac: float | None = None
    """Fraction of the fleet's way in the last factory hour that was driven without a load."""
    use: UseView | None = None
    """None until vehicles have been heard for a while; the same holds for the two below."""
    atv_available_frac: float | None = None
    """Fraction of the vehicles' last hour in which they were heard and neither stopped nor in error."""
    machine_available_frac: float | None = None
    """Fraction of the machines' last hour in which they were heard and not in error."""
    commands: int = 0
    """Commands that vehicles obeyed in the last hour."""
    helps: int = 0
    """Calls for help by vehicles in the last hour."""
    deliveries_per_hour: tuple[float, ...] = ()
    """Transports handed over per factory hour, in the last 12 slots of 5 factory minutes, oldest first."""
    atvs_by_status: dict[str, int] = msgspec.field(default_factory=dict)
    machines_by_status: dict[str, int] = msgspec.field(default_factory=dict)
    speed: float = 1.0
    """Factory seconds per real second."""
    behind_s: float = 0.0
    """Age of the plant's newest message, in real seconds; an agent heard before that is silent."""
    plant_at_s: float | None = None
    """When `GET /api/plant` changed last at this gateway: at its start, or when people defined or removed a product, or a machine joined."""
