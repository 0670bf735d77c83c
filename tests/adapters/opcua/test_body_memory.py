"""What a body remembers belongs to the counter and the kind of body that it was made from: what does not fit is in doubt, with a name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import msgspec
import pytest
from gate_rig import SHAFTS, SIGNALS, GateRig
from signals_rig import ALL, OTHER, PRODUCT, TWO_BITS, Rig
from test_signalled_gate import (
    test_a_goal_is_not_said_to_be_shut_while_the_controller_refuses_the_end_of_its_permit as gate_refuses,
)
from test_signalled_gate import (
    test_a_goal_is_said_to_be_shut_when_its_permit_can_bring_nothing_in_any_more as gate_is_cut,
)
from test_signalled_workcell import (
    test_a_piece_of_which_nobody_knows_the_product_is_in_doubt_and_counts_as_the_confirmed_one as machine_is_cut,
)
from test_signalled_workcell import (
    test_a_product_that_the_controller_has_confirmed_is_the_one_that_it_makes as machine_has_heard,
)

from dray.adapters.memory_file import MemoryFile
from dray.adapters.mqtt.mapping_file import MqttMapping
from dray.adapters.opcua.mapping_file import OpcUaMapping
from dray.adapters.people.workcell import DAMAGED as DAMAGED_PEOPLE
from dray.adapters.people.workcell import Kept as PeopleKept
from dray.adapters.signals import gate, workcell
from dray.adapters.signals.counting import CounterState
from dray.adapters.signals.gate import DAMAGED_SIGNALS, SETTLE_S, KeptSignals, SignalledGate
from dray.adapters.signals.signal import Edge, Signal, SignalMapping, Tag
from dray.adapters.signals.store import DAMAGED_STORE, KeptStore
from dray.adapters.signals.workcell import DAMAGED, Kept, SignalledWorkcell
from dray.body import CycleDone, ResetFault
from dray.cli.runtime.bodies.embodied import BY_CONTROLLER, BY_PEOPLE, BY_SIGNALS, lived

FIRST = Tag("pieces", rolls_over_at=10_000)
PRESS = "opc.tcp://press-1.plant:4840"


def by_opcua(url: str, **nodes: Tag) -> SignalMapping:
    return OpcUaMapping(url=url, signals={Signal(name): tag for name, tag in nodes.items()})


OTHERS = [
    pytest.param(Tag("good", rolls_over_at=10_000), "good", id="another node"),
    pytest.param(Tag("pieces", rolls_over_at=2**16), "up to 65,536", id="another modulus"),
    pytest.param(Tag("pieces"), "pieces", id="no modulus"),
    pytest.param(Tag("pieces", rolls_over_at=10_000, scale=10.0), "scale 10", id="another scale"),
    pytest.param(Tag(topic="press/1", path="good"), "press/1 good", id="a topic"),
    pytest.param(Tag("pieces", edge=Edge.RISING), "edge rising", id="pulses"),
]


def made(rig: Rig) -> list[str]:
    return [report.product for report in rig.heard() if isinstance(report, CycleDone)]


def machine_then(tag: Tag) -> Rig:
    """A machine whose counter stood at 9,998, in the next life of its agent with another mapping."""
    rig = Rig(TWO_BITS | {Signal.PIECES: FIRST}, ALL)
    rig.kept = msgspec.structs.replace(
        rig.kept or Kept(dict(ALL)),
        pieces=CounterState(9_998, rig.clock.now_s(), rig.mapping.source("pieces", (10_000,))),
    )
    rig.mapping = SignalMapping(TWO_BITS | {Signal.PIECES: tag}, ALL)
    rig.begin()
    rig.clock.pass_s(3_600.0)
    return rig


@pytest.mark.parametrize(("tag", "words"), OTHERS)
def test_another_counter_of_a_machine_is_counted_afresh_and_in_doubt_with_both_names(
    tag: Tag, words: str
) -> None:
    rig = machine_then(tag)
    is_pulse = tag.edge is not None
    # Without a look at where it comes from, the first ones would be pieces: after a roll over, or grown.
    rig.tell(Signal.PIECES, True if is_pulse else 9_999 if tag.scale == 1.0 else 99_990)
    rig.body.on_link()
    assert made(rig) == []
    assert words in rig.state.broken
    assert "and was read from pieces, up to 10,000" in rig.state.broken
    # It stays in doubt over another life, and goes on from what it shows.
    rig.begin()
    rig.body.on_link()
    assert words in rig.state.broken
    rig.body.instruct(ResetFault())
    if not is_pulse:
        rig.tell(Signal.PIECES, 10_000 if tag.scale == 1.0 else 100_000)
        rig.clock.pass_s(60.0)
        assert len(made(rig)) == 1
    assert rig.state.broken == ""


def test_the_same_counter_goes_on_and_one_of_an_older_version_does_too() -> None:
    rig = machine_then(FIRST)
    rig.tell(Signal.PIECES, 3)
    rig.body.on_link()
    assert (len(made(rig)), rig.state.broken) == (5, "")
    rig = machine_then(Tag("pieces", rolls_over_at=2**16))
    assert rig.kept is not None
    rig.kept = msgspec.structs.replace(rig.kept, pieces=CounterState(9_998, rig.clock.now_s()))
    rig.begin()
    rig.tell(Signal.PIECES, 9_999)
    rig.body.on_link()
    assert (len(made(rig)), rig.state.broken) == (1, "")


def test_a_node_that_has_got_another_type_may_not_have_rolled_over() -> None:
    rig = Rig(TWO_BITS, ALL)
    # Where it ends may become known later than what it shows.
    rig.body.on_range(Signal.PIECES, (2**32,))
    rig.tell(Signal.PIECES, 2)
    assert (len(made(rig)), rig.state.broken) == (2, "")
    rig.begin()
    rig.body.on_range(Signal.PIECES, (2**16,))
    rig.tell(Signal.PIECES, 3)
    rig.body.on_link()
    assert made(rig) == []
    assert "up to 65,536" in rig.state.broken


def test_the_same_node_of_another_server_is_another_counter() -> None:
    first = by_opcua(PRESS, pieces=FIRST)
    assert first.source("pieces") == by_opcua(PRESS, pieces=FIRST).source("pieces")
    assert first.source("pieces") != by_opcua(PRESS.replace("1", "2"), pieces=FIRST).source("pieces")
    topics = MqttMapping(signals={Signal.PIECES: Tag(topic="press/1", path="good")})
    assert topics.source("pieces") == "press/1 good"


def test_the_same_node_in_another_life_of_a_simulated_floor_is_another_counter() -> None:
    rig = Rig(TWO_BITS, ALL)
    nodes = {str(name): tag for name, tag in TWO_BITS.items()}
    for life in ("", "one", "two"):
        rig.mapping = msgspec.structs.replace(by_opcua(PRESS, **nodes), life=life, stock=ALL)
        rig.begin()
        rig.tell(Signal.PIECES, 1)
        rig.body.on_link()
        assert (made(rig), f"life {life}" in rig.state.broken) == ([], bool(life))
        rig.body.instruct(ResetFault())
        rig.clock.pass_s(60.0)
        rig.tell(Signal.PIECES, 2)
        assert len(made(rig)) == 1


BROKERS = "mqtt://north:1883", "mqtt://south:1883"


def test_the_same_topic_of_another_broker_is_another_counter_of_a_machine() -> None:
    rig = Rig(TWO_BITS | {Signal.PIECES: Tag(topic="press/1", path="good")}, ALL)
    # The first life is of an older version, which did not know of its broker.
    for broker, pieces in ((BROKERS[0], 1), (BROKERS[0], 2), (BROKERS[1], 0)):
        rig.broker = broker
        rig.begin()
        rig.clock.pass_s(60.0)
        rig.tell(Signal.PIECES, pieces)
        rig.body.on_link()
        assert len(made(rig)) == bool(pieces)
    assert f"is read from press/1 good of {BROKERS[1]}, and was read from press/1 good of {BROKERS[0]}" in (
        rig.state.broken
    )


def test_the_same_topic_of_another_broker_is_another_counter_of_the_gate() -> None:
    rig = GateRig()
    rig.broker = BROKERS[0]
    rig.begin()
    rig.show(SHAFTS)
    rig.broker = BROKERS[1]
    rig.begin()
    assert BROKERS[0] in rig.body.away
    assert BROKERS[1] in rig.body.away


@pytest.mark.parametrize("product", [None, Tag(topic="press/1/order")])
def test_a_product_that_another_controller_has_confirmed_is_no_product_of_this_one(
    product: Tag | None,
) -> None:
    """By MQTT nothing is confirmed: what is made after a broken connection counts as the wanted product, without a doubt."""
    rig = Rig(TWO_BITS | {Signal.PRODUCT: Tag("product")}, ALL)
    rig.start()
    rig.confirm(Signal.PRODUCT)
    rig.clock.pass_s(60.0)
    rig.tell(Signal.PIECES, 1)
    rig.mapping = SignalMapping(TWO_BITS | ({} if product is None else {Signal.PRODUCT: product}), ALL)
    rig.begin()
    rig.tell(Signal.PIECES, 1)
    rig.body.on_link()
    rig.clock.pass_s(600.0)
    rig.heard()
    rig.start(OTHER)
    assert rig.body.outputs[Signal.RUN] is True
    rig.body.on_link_lost("cut")
    rig.clock.pass_s(60.0)
    rig.tell(Signal.PIECES, 2)
    rig.body.on_link()
    assert (made(rig), rig.state.broken) == ([OTHER], "")


def gate_then(tag: Tag, *, is_open: bool) -> GateRig:
    """A gate whose counter stood at 9,998, in the next life of its agent with another mapping."""
    rig = GateRig(FIRST, first=9_998)
    if is_open:
        rig.show(SHAFTS)
    rig.mapping = SignalMapping(SIGNALS | {Signal.PIECES: tag})
    rig.shown = True if tag.edge else 9_999 if tag.scale == 1.0 else 99_990
    return rig


@pytest.mark.parametrize(("tag", "words"), OTHERS)
def test_another_counter_of_a_gate_that_was_open_is_in_doubt_with_both_names(tag: Tag, words: str) -> None:
    rig = gate_then(tag, is_open=True)
    rig.begin()
    assert words in rig.body.away
    assert "and was read from pieces, up to 10,000" in rig.body.away
    assert rig.arrived == {}
    rig.clock.pass_s(2 * SETTLE_S)
    rig.check({SHAFTS: 4})
    rig.begin()
    rig.clock.pass_s(SETTLE_S)
    assert (rig.body.away, rig.arrived, rig.told) == ("", {SHAFTS: 4}, (SHAFTS, 6))


@pytest.mark.parametrize(("tag", "words"), OTHERS)
def test_another_counter_of_a_gate_that_was_shut_has_missed_nothing(tag: Tag, words: str) -> None:
    rig = gate_then(tag, is_open=False)
    rig.begin()
    assert words
    assert (rig.body.away, rig.arrived) == ("", {})
    # Another life knows where it goes on.
    rig.begin()
    assert (rig.body.away, rig.arrived) == ("", {})


# --- another kind of body ---


def machine_file(folder: Path) -> MemoryFile[Kept]:
    return MemoryFile(folder / "M8.workcell.json", Kept, DAMAGED)


def test_what_a_body_has_kept_is_not_used_after_another_kind_of_body(tmp_path: Path) -> None:
    before = Kept({PRODUCT: 7})
    assert lived(tmp_path, "M8", BY_SIGNALS, machine_file(tmp_path)) is None
    machine_file(tmp_path).write(before)
    assert lived(tmp_path, "M8", BY_SIGNALS, machine_file(tmp_path)) == before
    people: MemoryFile[PeopleKept] = MemoryFile(tmp_path / "M8.people.json", PeopleKept, DAMAGED_PEOPLE)
    assert lived(tmp_path, "M8", BY_PEOPLE, people) is None
    for _ in range(2):  # It stays so until people have counted.
        kept = lived(tmp_path, "M8", BY_SIGNALS, machine_file(tmp_path))
        assert kept == Kept({}, doubt="people counted before it; see what is there")
    aside = (tmp_path / "M8.workcell.outdated").read_bytes()
    assert msgspec.json.decode(aside, type=Kept) == before


def test_a_life_that_was_killed_as_it_said_that_its_memory_is_outdated_keeps_the_old_one_aside(
    tmp_path: Path,
) -> None:
    before = Kept({PRODUCT: 7})
    machine_file(tmp_path).write(before)
    for _ in range(2):
        lived(tmp_path, "M8", BY_PEOPLE)
        kept = lived(tmp_path, "M8", BY_SIGNALS, machine_file(tmp_path))
        assert kept is not None
        assert kept.doubt
    assert msgspec.json.decode((tmp_path / "M8.workcell.outdated").read_bytes(), type=Kept) == before


def test_a_storage_is_counted_again_after_another_kind_of_body(tmp_path: Path) -> None:
    file: MemoryFile[KeptStore] = MemoryFile(tmp_path / "S3.store.json", KeptStore, DAMAGED_STORE)
    file.write(KeptStore({"steel": 40}))
    lived(tmp_path, "S3", BY_CONTROLLER)
    assert lived(tmp_path, "S3", BY_SIGNALS, file) == DAMAGED_STORE


def test_a_gate_with_a_counter_knows_nothing_of_what_people_have_counted_before_it(tmp_path: Path) -> None:
    file: MemoryFile[KeptSignals] = MemoryFile(tmp_path / "gate.signals.json", KeptSignals, DAMAGED_SIGNALS)
    assert lived(tmp_path, "gate", BY_PEOPLE) is None
    kept = lived(tmp_path, "gate", BY_SIGNALS, file, always=True)
    assert kept == KeptSignals(doubt="people counted before it; see what is there")


# --- bodies that are broken on purpose ---


def with_machines_that_are_sure_of_their_product(patch: pytest.MonkeyPatch) -> None:
    """A machine takes what it has asked for for what is made."""
    patch.setattr(SignalledWorkcell, "_hold_unconfirmed", lambda _self: False)


def with_machines_that_hear_no_confirmation(patch: pytest.MonkeyPatch) -> None:
    """A machine does not hear that the controller has its product."""
    heard = SignalledWorkcell.on_written

    def listen_once(self: SignalledWorkcell, name: str, value: object) -> None:
        if not self._kept.confirmed:
            heard(self, name, value)  # type: ignore[arg-type]

    patch.setattr(SignalledWorkcell, "on_written", listen_once)


def with_a_gate_that_is_sure_of_what_it_admits(patch: pytest.MonkeyPatch) -> None:
    """A gate says at once that fewer pieces come in, though its permit may bring more."""
    patch.setattr(SignalledGate, "_is_exceeded", lambda _self, _name: False)


def with_bodies_that_take_any_counter_for_theirs(patch: pytest.MonkeyPatch) -> None:
    """Where a count comes from is not looked at."""
    for module in (workcell, gate):
        patch.setattr(module, "doubt_of_another", lambda *_: "")


MUTANTS: list[tuple[Callable[[pytest.MonkeyPatch], None], Callable[[], None]]] = [
    (with_machines_that_are_sure_of_their_product, lambda: machine_is_cut(False)),
    (with_machines_that_are_sure_of_their_product, lambda: machine_is_cut(True)),
    (with_machines_that_hear_no_confirmation, machine_has_heard),
    (with_a_gate_that_is_sure_of_what_it_admits, lambda: gate_is_cut(is_cut=True)),
    (with_a_gate_that_is_sure_of_what_it_admits, lambda: gate_is_cut(is_cut=False)),
    (with_a_gate_that_is_sure_of_what_it_admits, gate_refuses),
    (
        with_bodies_that_take_any_counter_for_theirs,
        lambda: test_another_counter_of_a_machine_is_counted_afresh_and_in_doubt_with_both_names(
            Tag("pieces", rolls_over_at=2**16), "65,536"
        ),
    ),
    (
        with_bodies_that_take_any_counter_for_theirs,
        lambda: test_another_counter_of_a_gate_that_was_open_is_in_doubt_with_both_names(
            Tag("good", rolls_over_at=10_000), "good"
        ),
    ),
]


@pytest.mark.parametrize(("mutant", "story"), MUTANTS)
def test_a_body_that_is_broken_on_purpose_is_found(
    mutant: Callable[[pytest.MonkeyPatch], None],
    story: Callable[[], None],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with monkeypatch.context() as patch:
        mutant(patch)
        with pytest.raises(AssertionError):
            story()
    story()
