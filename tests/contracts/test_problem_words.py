"""Problems of controllers and vehicles, and reasons for not bidding, have words in the panels, with their figures filled in."""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from itertools import product
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from asyncua import ua

sys.path.insert(0, str(Path(__file__).parents[1] / "adapters/opcua"))

from signals_rig import ALL, COUNTER, OTHER, PRODUCT, PULSE, TWO_BITS, HandClock, Rig

from dray.adapters.mqtt.values import sample_of as mqtt_sample
from dray.adapters.opcua.link import sample_of as opcua_sample
from dray.adapters.opcua.link import words as opcua_words
from dray.adapters.signals.gate import DAMAGED_SIGNALS, KeptSignals, SignalledGate
from dray.adapters.signals.signal import OF_A_GATE, Edge, Quality, Sample, Signal, SignalMapping, Tag, Value
from dray.adapters.signals.workcell import DAMAGED
from dray.adapters.vda5050.control.orders import (
    FORGOTTEN,
    REFUSED_SILENTLY,
    STOPPED_SHORT,
    VANISHED,
    Orders,
)
from dray.adapters.vda5050.control.vehicle_order import NOBODY_LOADS, ONLY_WAITS
from dray.body import Admit
from dray.cli.runtime.bodies.embodied import BY_CONTROLLER, BY_PEOPLE, BY_SIGNALS, with_doubt
from dray.protocol.contract_net.trust.probation import ON_PROBATION
from dray.protocol.vehicle.unplaced import LAST_AT, NEVER_TOLD

TEXT = Path(__file__).parents[2] / "frontend/src/text"

PATTERN = re.compile(r'^  \{ says: /(.+)/, key: "([\w.]+)" \},$', re.MULTILINE)
LINE = re.compile(r'^  "((?:failure|why|until)\.[^"]+)": "(.*)",$', re.MULTILINE)

SENTENCES = [
    (re.compile(says.replace("(?<", "(?P<").replace("(?P<!", "(?<!").replace(r"\/", "/")), key)
    for says, key in PATTERN.findall((TEXT / "failure.ts").read_text(encoding="utf-8"))
]

GOAL = "O-7-1.1"


def words(language: str) -> dict[str, str]:
    """By key, what panels say."""
    return dict(LINE.findall((TEXT / f"shared/{language}.ts").read_text(encoding="utf-8")))


class Gate:
    """One gate, with ten pieces of a goal admitted."""

    def __init__(self, *, pulse: bool = False, kept: KeptSignals | None = None) -> None:
        tags = {signal: Tag(signal.value) for signal in (Signal.PIECES, *OF_A_GATE, Signal.FAULT)}
        if pulse:
            tags[Signal.PIECES] = Tag("pulse", edge=Edge.RISING)
        self.clock = HandClock()
        self.body = SignalledGate(SignalMapping(tags), self.clock, self, kept, settle_s=1.0)
        self.body.attach(lambda _report: None)
        self.body.instruct(Admit(GOAL, 10))
        self.body.on_link()
        self.tell(Signal.FAULT, False)
        self.tell(Signal.PIECES, False if pulse else 500)
        self.tell(Signal.GOAL, "")
        self.clock.pass_s(5.0)

    def remember(self, kept: KeptSignals) -> None:
        """Nothing outlives it."""

    def write(self) -> None:
        """Nobody reads it."""

    def tell(self, signal: Signal, value: Value, quality: Quality = Quality.GOOD, reason: str = "") -> None:
        self.body.on_sample(signal, Sample(value, quality, reason))

    def open(self) -> None:
        self.tell(Signal.GOAL, GOAL)
        self.clock.pass_s(5.0)
        assert self.body.outputs[Signal.ADMITTED] == 10

    def lose(self, reason: str) -> None:
        self.body.on_link_lost(reason)


def gate(act: Callable[[Gate], None], *, pulse: bool = False, kept: KeptSignals | None = None) -> str:
    """What a gate reports after something has happened."""
    one = Gate(pulse=pulse, kept=kept)
    act(one)
    return one.body.problem


def machine(
    act: Callable[[Rig], None],
    signals: dict[Signal, Tag] | None = None,
    stock: dict[str, int] | None = None,
) -> str:
    """What a machine reports after something has happened."""
    rig = Rig(signals, stock)
    act(rig)
    return rig.state.broken


def gate_is_reset(one: Gate) -> None:
    one.open()
    one.lose("it does not answer")
    one.body.on_link()
    one.tell(Signal.PIECES, 2)
    one.tell(Signal.GOAL, GOAL)


def pulses_are_missed(one: Gate) -> None:
    one.open()
    one.tell(Signal.PIECES, False, Quality.BAD)
    one.tell(Signal.PIECES, False)


def permit_is_refused(one: Gate) -> None:
    one.open()
    one.body.on_refused(Signal.ADMITTED, "BadOutOfRange")


def zero_is_refused(one: Gate) -> None:
    one.body.on_refused(Signal.ADMITTED, "BadOutOfRange")


def machine_is_reset(rig: Rig) -> None:
    rig.tell(Signal.PIECES, 500)
    rig.body.on_link_lost("it does not answer")
    rig.clock.pass_s(3_600.0)
    rig.tell(Signal.PIECES, 2)
    rig.body.on_link()


def machine_begins_with_a_damaged_memory(rig: Rig) -> None:
    rig.kept = DAMAGED
    rig.begin()
    rig.tell(Signal.PIECES, 0)
    rig.body.on_link()


def machine_begins_with_another_counter(rig: Rig) -> None:
    rig.tell(Signal.PIECES, 1)
    rig.mapping = SignalMapping({Signal.PIECES: Tag("good", rolls_over_at=10_000)})
    rig.begin()
    rig.tell(Signal.PIECES, 1)
    rig.body.on_link()


def machine_begins_after(kind: str) -> Callable[[Rig], None]:
    """Where another kind of body has counted."""

    def begin(rig: Rig) -> None:
        rig.kept = with_doubt(DAMAGED, kind)
        rig.begin()
        rig.tell(Signal.PIECES, 0)
        rig.body.on_link()

    return begin


def gate_has_another_counter_in_mid_permit(one: Gate) -> None:
    one.open()
    one.body.on_range(Signal.PIECES, (2**32,))
    one.tell(Signal.PIECES, 501)
    one.body.on_range(Signal.PIECES, (2**16,))
    one.tell(Signal.PIECES, 502)


def machine_is_asked_for_another_product_as_it_breaks(rig: Rig) -> None:
    rig.body.on_written(Signal.PRODUCT, PRODUCT)
    rig.start(OTHER)
    rig.body.on_link_lost("it does not answer")
    rig.tell(Signal.PIECES, 1)
    rig.body.on_link()


def machine_makes_nothing(rig: Rig) -> None:
    rig.start()
    rig.clock.pass_s(86_400.0)


def messages() -> Iterator[str]:
    """Why a message or a value is none."""
    for data, path in (
        (b"x" * 70_000, ""),
        (b"[" * 60_000, ""),
        (b"{", ""),
        (b"{}", "count.good"),
        (b"null", ""),
        (b"[1]", ""),
    ):
        yield mqtt_sample(data, path).reason
    for value in (None, [1, 2]):
        yield opcua_sample(ua.DataValue(ua.Variant(value))).reason


def lost() -> Iterator[str]:
    """Why a controller is not heard."""
    yield f"opc.tcp://press-1.plant:4840: {opcua_words(TimeoutError())}"
    yield "mqtts://broker.plant:8883: nothing was said for 2.5 s"


MACHINES = {
    "jumps": lambda rig: rig.tell(Signal.PIECES, 10_000),
    "counts backwards": lambda rig: [rig.tell(Signal.PIECES, each) for each in (1, 2, 3, 4, -1)],
    "is no count": lambda rig: rig.tell(Signal.PIECES, "much"),
    "has a bad value": lambda rig: rig.tell(Signal.PIECES, 7, Quality.BAD),
    "has an uncertain value": lambda rig: rig.tell(Signal.PIECES, 7, Quality.UNCERTAIN),
    "was reset unheard": machine_is_reset,
    "has a damaged memory": machine_begins_with_a_damaged_memory,
    "makes nothing": machine_makes_nothing,
    "has another counter": machine_begins_with_another_counter,
    **{f"had {kind}": machine_begins_after(kind) for kind in (BY_SIGNALS, BY_PEOPLE, BY_CONTROLLER)},
}

GATES = {
    "jumps": lambda one: one.tell(Signal.PIECES, 9_000),
    "counts backwards": lambda one: one.tell(Signal.PIECES, 490),
    "was reset unheard": gate_is_reset,
    "has another counter": gate_has_another_counter_in_mid_permit,
    "is no count": lambda one: one.tell(Signal.PIECES, "much"),
    "is no label": lambda one: one.tell(Signal.GOAL, 7),
    "has a bad value": lambda one: one.tell(Signal.PIECES, 7, Quality.BAD),
    "was not heard yet": lambda one: (one.lose("it does not answer"), one.body.on_link()),
    "has a fault": lambda one: one.tell(Signal.FAULT, True),
    "has a numbered fault": lambda one: one.tell(Signal.FAULT, 17),
    "refuses a permit": permit_is_refused,
    "refuses the end of a permit": zero_is_refused,
}

SAID = [
    *((f"machine {name}", lambda act=act: machine(act)) for name, act in MACHINES.items()),
    *((f"gate {name}", lambda act=act: gate(act)) for name, act in GATES.items()),
    (
        "machine says true for a state",
        lambda: machine(lambda rig: rig.tell(Signal.STATE, "odd"), COUNTER | {Signal.STATE: Tag("s")}),
    ),
    (
        "machine is not available",
        lambda: machine(lambda rig: rig.tell(Signal.STATE, 0), COUNTER | {Signal.STATE: Tag("s")}),
    ),
    (
        "machine may have made either product",
        lambda: machine(machine_is_asked_for_another_product_as_it_breaks, stock=ALL),
    ),
    ("machine has a fault", lambda: machine(lambda rig: rig.tell(Signal.FAULT, 3), TWO_BITS)),
    ("machine has no pulse", lambda: machine(lambda rig: rig.tell(Signal.PIECES, 3), PULSE)),
    ("gate pulses unheard", lambda: gate(pulses_are_missed, pulse=True)),
    ("gate pulses too much", lambda: gate(lambda one: one.tell(Signal.PIECES, True), pulse=True)),
    ("gate remembers nothing", lambda: gate(lambda _: None, kept=DAMAGED_SIGNALS)),
    *(
        (f"value {number}", lambda why=why: machine(lambda rig: rig.tell(Signal.PIECES, 0, Quality.BAD, why)))
        for number, why in enumerate(messages())
    ),
    *(
        (f"link {number}", lambda why=why: gate(lambda one: one.lose(why)))
        for number, why in enumerate(lost())
    ),
]


@pytest.mark.parametrize("said", [pytest.param(say, id=name) for name, say in SAID])
def test_every_problem_of_a_controller_has_words_down_to_its_figures(said: Callable[[], str]) -> None:
    problem = said()
    assert problem
    assert unknown(problem) == []


PACKAGE = Path(__file__).parents[2] / "backend/dray"

WRITTEN = (
    ("protocol/vehicle/charging.py", "why_no_work"),
    ("protocol/vehicle/bidding.py", "on_announced"),
    ("protocol/vehicle/bidding.py", "_consider"),
    ("protocol/machine/products.py", "objection"),
    ("adapters/vda5050/control/watch.py", "_stuck"),
)
"""Functions that write sentences, each with its file."""


def sentences(file: str, function: str) -> list[str]:
    """The sentences of a function, with 7 for whatever is filled in."""
    tree = ast.parse((PACKAGE / file).read_text(encoding="utf-8"))
    (body,) = (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef) and node.name == function)
    written = (
        value
        for node in ast.walk(body)
        if isinstance(node, ast.Call | ast.Return)
        for value in (
            [*node.args, *(each.value for each in node.keywords)]
            if isinstance(node, ast.Call)
            else [node.value]
        )
    )
    return ["".join(map(shown, getattr(value, "values", [value]))) for value in written if is_text(value)]


DRIVER = (
    ("problems.py", "absence"),
    ("problems.py", "complaint"),
    ("master.py", "why_unknown"),
    ("master.py", "_what_it_waits_for"),
    ("master.py", "_find_problem"),
    ("master.py", "_failure"),
    ("hold.py", "tick"),
    ("unwilling.py", "problem"),
    ("orders.py", "overlong"),
    ("charge_watch.py", "look"),
    ("undriven_orders.py", "problem"),
    ("on_board.py", "lose_track"),
    ("on_board.py", "on_state"),
    ("work.py", "drive"),
    ("work.py", "_why_not"),
    ("work.py", "locate"),
    ("work.py", "_end_step"),
    ("steps.py", "next"),
)
"""Functions of the driver of a vehicle with VDA 5050 that write sentences for people, each with its file."""

FILLED_IN: dict[str, tuple[str, ...]] = {
    "unlinked[0]": ("mqtts://broker.plant:8883: nothing was said for 2.5 s",),
    "self._unlinked[0]": ("mqtts://broker.plant:8883: nothing was said for 2.5 s",),
    "view.away": ("OFFLINE", "CONNECTION_BROKEN"),
    "' or '.join(known)": ("hall", "hall or yard"),
    "self._hindrance": ("it says that it drives",),
    "order.reason": (REFUSED_SILENTLY, FORGOTTEN, STOPPED_SHORT, VANISHED, ONLY_WAITS, NOBODY_LOADS),
    "problems.py: where": ("x 7 m, y 7 m",),
    "master.py: where": ("", ": (1.0, 2.0)"),
    "obeys": ("it does not pause", "it does not stop"),
    "why": ("it does not say why", REFUSED_SILENTLY),
    "what": ("pick", "drop"),
    "theirs": ("nothing", "a load"),
    "ours": ("nothing", "4 shaft"),
}
"""What may be filled in where a figure or a name would not do, by its expression, in one file or in all."""


def parts(value: ast.expr | None) -> Iterator[ast.expr]:
    """The expressions that a value may be, or that stand in it side by side."""
    match value:
        case ast.Tuple(elts=several) | ast.BoolOp(values=several):
            for each in several:
                yield from parts(each)
        case ast.IfExp(body=one, orelse=other):
            yield from parts(one)
            yield from parts(other)
        case ast.Constant() | ast.JoinedStr():
            yield value


def filled_in(expression: str, file: str) -> Sequence[str]:
    return FILLED_IN.get(f"{file}: {expression}") or FILLED_IN.get(expression, ("7",))


def alternatives(value: ast.expr, file: str) -> list[str]:
    """A sentence of the driver, with each of what may be filled in."""
    if isinstance(value, ast.Constant):
        return [str(value.value)]
    assert isinstance(value, ast.JoinedStr)
    choices = [
        filled_in(ast.unparse(part.value), file)
        if isinstance(part, ast.FormattedValue)
        else alternatives(part, file)
        for part in value.values
    ]
    return ["".join(each) for each in product(*choices)]


def said_by_driver(file: str, function: str) -> list[str]:
    """The sentences that a function of the driver returns, hands over or keeps."""
    tree = ast.parse((PACKAGE / "adapters/vda5050/control" / file).read_text(encoding="utf-8"))
    (body,) = (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef) and node.name == function)
    values: list[ast.expr | None] = []
    for node in ast.walk(body):
        match node:
            case ast.Call(args=args):
                values += args
            case ast.Return(value=value):
                values.append(value)
            case ast.Assign(targets=[ast.Attribute()], value=value):
                values.append(value)
    texts = (part for value in values for part in parts(value) if is_text(part))
    return [text for part in texts for text in alternatives(part, file)]


def ends_a_wait(said: str) -> bool:
    """Whether panels have words for what would end a wait."""
    english = words("en")
    filled = (english[key] for says, key in SENTENCES if key.startswith("until.") and says.match(said))
    return f"until.{said}" in english or next(filled, None) is not None


@pytest.mark.parametrize(("file", "function"), DRIVER)
def test_every_sentence_of_the_driver_of_a_vehicle_has_words(file: str, function: str) -> None:
    found = said_by_driver(file, function)
    assert found
    assert [said for said in found if unknown(said) and not ends_a_wait(said)] == []


@pytest.mark.parametrize(
    "said",
    [
        "it has not come nearer to m8 for 65 s: it stands; it reports: motorFault: axis 2",
        "it has not come nearer to m8 for 65 s: it says that it drives, at speed 0; it reports: operatingMode ECO",
        "its action pick has not ended for 300 s: its status is COMPLETED",
        "its action pick has not ended for 300 s: its status is COMPLETED; it reports: liftFault; lowOil: 3 l",
        "its action pick has not ended for 300 s: it reports: liftFault",
        "it has ended 3 orders one after the other, and has not driven: it says that its last node is m8, and is 9.5 m before it",
        f"it has ended 3 orders one after the other, and has not driven: {STOPPED_SHORT}",
    ],
)
def test_what_a_vehicle_that_does_not_get_on_reports_stands_in_words(said: str) -> None:
    assert [part for part in unknown(said) if part not in OF_THE_VEHICLE] == []


OF_THE_VEHICLE = (
    "motorFault: axis 2",
    "operatingMode ECO",
    "COMPLETED",
    "liftFault; lowOil: 3 l",
    "liftFault",
)


@pytest.mark.parametrize(
    "said",
    [
        NEVER_TOLD.format("the broker is away: no route to host"),
        LAST_AT.format("n7", "the vehicle has not said where it is"),
    ],
)
def test_a_call_of_a_vehicle_that_tells_no_place_has_words(said: str) -> None:
    assert [part for part in unknown(said) if part != "no route to host"] == []


def test_what_a_vehicle_says_before_its_first_state_has_words() -> None:
    assert unknown("the vehicle has not said anything yet that can be used: 3 times not JSON") == []


@pytest.mark.parametrize(
    "reason", [REFUSED_SILENTLY, FORGOTTEN, STOPPED_SHORT, VANISHED, ONLY_WAITS, NOBODY_LOADS]
)
def test_why_an_order_of_a_vehicle_has_ended_has_words(reason: str) -> None:
    assert unknown(reason) == []


@pytest.mark.parametrize("foreign", [False, True])
@pytest.mark.parametrize("does", ["drives", "acts", "shows nodes"])
def test_why_a_vehicle_takes_no_order_has_words(does: str, foreign: bool) -> None:
    action = SimpleNamespace(action_type="pick", action_id="a1", action_status="RUNNING")
    view: Any = SimpleNamespace(
        is_idle=False,
        is_foreign=foreign,
        is_driving=does == "drives",
        acting=[action] if does == "acts" else [],
        state=SimpleNamespace(order_id="other-7"),
    )
    nobody: Any = None
    orders = Orders("ATV1", 1, nobody, view, nobody, [], nobody, lambda: None)
    hindrance = orders.hindrance(10.0)
    assert hindrance
    assert unknown(hindrance) == []
    assert unknown(f"it takes no order: {hindrance}") == []


def is_text(value: ast.expr | None) -> bool:
    """Whether an expression is a sentence, or one in which something is filled in."""
    parts = value.values if isinstance(value, ast.JoinedStr) else [value]
    return any(
        isinstance(each, ast.Constant) and isinstance(each.value, str) and " " in each.value for each in parts
    )


def shown(part: ast.expr) -> str:
    if isinstance(part, ast.Constant):
        return str(part.value)
    assert isinstance(part, ast.FormattedValue)
    is_share = part.format_spec is not None and "%" in ast.unparse(part.format_spec)
    if isinstance(part.value, ast.Name) and part.value.id == "why":
        return "it stands, and does not say why"
    if isinstance(part.value, ast.Name) and part.value.id == "ON_PROBATION":
        return ON_PROBATION
    return "7%" if is_share else "7"


@pytest.mark.parametrize(("file", "function"), WRITTEN)
def test_every_sentence_of_an_agent_has_words(file: str, function: str) -> None:
    found = sentences(file, function)
    assert found
    assert [said for said in found if unknown(said)] == []


# What the controller or a library says in its own words.
THEIRS = frozenset({"BadOutOfRange", "4 shaft"})


def unknown(said: str) -> list[str]:
    """The parts of a sentence that panels show in the controller's English."""
    english = words("en")
    for says, key in SENTENCES:
        if not key.startswith("until.") and (found := says.match(said)):
            groups = found.groupdict()
            if key.startswith("why."):
                assert english[key].replace("\u00a0", " ").format(**groups) == said
            inner = [groups[name] for name in ("why", "what", "theirs", "ours", "missing") if name in groups]
            return [part for each in inner for part in unknown(each)]
    return [] if said in THEIRS or f"why.{said}" in english or f"failure.{said}" in english else [said]


@pytest.mark.parametrize("language", ["de", "es"])
def test_other_languages_fill_in_the_same_figures(language: str) -> None:
    english, other = words("en"), words(language)
    fields = re.compile(r"\{(\w+)\}")
    assert other.keys() == english.keys()
    assert {
        key for key in english if set(fields.findall(english[key])) != set(fields.findall(other[key]))
    } == set()
    shared = {"why.at"}
    assert {key for key in english if key.startswith("why.") and other[key] == english[key]} == shared
