"""The codec: what we say can be read, and nothing that comes in can hurt."""

from __future__ import annotations

import contextlib
import enum
import functools
import json
import types
import typing
from typing import Any, cast

import msgspec
import pytest
from hypothesis import given, reject, settings
from hypothesis import strategies as st

from dray.codec import MAX_BYTES, decode, encode
from dray.errors import NewerVersion, WireError
from dray.messages import (
    AnyMessage,
    AtvHeartbeat,
    AtvStatus,
    Brief,
    Handover,
    Message,
    OrderReleased,
    OrderTaken,
    Pose,
    Role,
)
from dray.messages.product import Address, MediaType, Sha256

HEARTBEAT = AtvHeartbeat(
    atv="ATV-07",
    incarnation=2,
    seq=41,
    at_s=1234.5,
    status=AtvStatus.WORKING,
    pose=Pose(x_m=3.0, y_m=4.5, heading_rad=0.1),
    node="n12",
    speed_mps=1.2,
    battery_frac=0.7,
    task=Brief(task="M1-3", epoch=2, role=Role.PRIMARY, coordinator="M1"),
    way=("n13", "n14"),
)


def wire(message: dict[str, Any], v: Any = 2, sender: Any = "ATV-07") -> bytes:
    return json.dumps({"v": v, "from": sender, "m": message}).encode()


TAKEN = {
    "type": "OrderTaken",
    "order": "o-1",
    "release": 1,
    "fulfilled": False,
    "change": 0,
    "quantities": [],
}


patiently = settings(deadline=None, max_examples=40)
"""How long one example takes says nothing about the codec on a busy machine."""

# --- any message: strategies built from the struct types themselves --------------------------------

MESSAGE_TYPES: tuple[type[Message], ...] = typing.get_args(AnyMessage)

_NO_IDS = {
    typing.get_args(kind)[1].pattern: value
    for kind, value in (
        (Address, "https://plm.example/p1.nc"),
        (MediaType, "application/pdf"),
        (Sha256, "ab" * 32),
    )
}
"""By pattern, something of it."""

_ID_CHARACTERS = st.characters(exclude_categories=("Cs", "Cc", "Zs", "Zl", "Zp"), exclude_characters="/*?#$@")


@st.composite
def messages(draw: st.DrawFn) -> Message:
    """Any message that may be said. Hypothesis writes down a strategy when it leaves an example out, and warns of a long one."""
    return cast(Message, draw(of_struct(draw(st.sampled_from(MESSAGE_TYPES)))))


@functools.cache
def of_struct(kind: type[msgspec.Struct]) -> st.SearchStrategy[Any]:
    """Any value of one struct type; fields with defaults are sometimes left out."""
    required: dict[str, st.SearchStrategy[Any]] = {}
    optional: dict[str, st.SearchStrategy[Any]] = {}
    for field in msgspec.structs.fields(kind):
        (required if field.required else optional)[field.name] = of_type(field.type)
    return st.fixed_dictionaries(required, optional=optional).map(functools.partial(made, kind))


def made(kind: type[msgspec.Struct], values: dict[str, Any]) -> msgspec.Struct:
    """A value of a type; one in which fields do not fit one another is not drawn."""
    try:
        return kind(**values)
    except ValueError:
        reject()


def of_type(hint: Any) -> st.SearchStrategy[Any]:
    """Any value of a field's type, within the bounds that are written on it."""
    origin, args = typing.get_origin(hint), typing.get_args(hint)
    if origin is typing.Annotated:
        return _bounded(args[0], args[1])
    if origin in (typing.Union, types.UnionType):
        return st.one_of([of_type(arg) for arg in args])
    if origin is typing.Literal:
        return st.sampled_from(args)
    if origin is tuple and args[-1] is not Ellipsis:
        return st.tuples(*[of_type(arg) for arg in args])
    if origin is tuple:
        return st.lists(of_type(args[0]), max_size=3).map(tuple)
    if origin is typing.Literal:
        return st.sampled_from(args)
    if hint is type(None):
        return st.none()
    if hint is msgspec.UnsetType:
        return st.just(msgspec.UNSET)
    if issubclass(hint, enum.Enum):
        return st.sampled_from(hint)
    if issubclass(hint, msgspec.Struct):
        return of_struct(hint)
    return {bool: st.booleans()}[hint]


def _bounded(hint: Any, meta: msgspec.Meta) -> st.SearchStrategy[Any]:
    if hint is int:
        return st.integers(int(meta.ge or 0), int(meta.le or 0))
    if hint is float:
        return st.floats(meta.ge, meta.le)
    if hint is str and meta.pattern in _NO_IDS:
        return st.just(_NO_IDS[meta.pattern])
    if hint is str and meta.pattern:
        return st.text(_ID_CHARACTERS, min_size=1 if "{1," in meta.pattern else 0, max_size=12)
    if hint is str:
        return st.text(st.characters(exclude_categories=["Cs"]), min_size=meta.min_length or 0, max_size=30)
    if hint is bytes:
        return st.binary(min_size=meta.min_length or 0, max_size=meta.max_length)
    return st.lists(of_type(typing.get_args(hint)[0]), min_size=meta.min_length or 0, max_size=3).map(tuple)


# --- there and back ------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", MESSAGE_TYPES, ids=lambda kind: kind.__name__)
def test_every_message_type_is_read_as_it_was_written(kind: type[Message]) -> None:
    @patiently
    @given(of_struct(kind))
    def there_and_back(message: Message) -> None:
        assert decode(encode("ATV-07", message)) == ("ATV-07", message)

    there_and_back()


@patiently
@given(messages())
def test_the_same_message_gives_the_same_bytes(message: Message) -> None:
    assert encode("a", message) == encode("a", decode(encode("a", message))[1])


def test_the_envelope_is_the_published_one() -> None:
    assert encode("ATV-07", OrderTaken(order="o-1")) == wire(TAKEN).replace(b" ", b"")


def test_fields_of_a_newer_software_are_ignored() -> None:
    data = json.dumps({"v": 2, "trace": "00-ab", "from": "S", "m": {**TAKEN, "mood": [1, {}]}}).encode()
    assert decode(data) == ("S", OrderTaken(order="o-1"))


# --- what is refused -----------------------------------------------------------------------------


@patiently
@given(st.binary(max_size=200))
def test_no_bytes_raise_anything_but_a_wire_error(data: bytes) -> None:
    with contextlib.suppress(WireError):
        decode(data)


@patiently
@given(messages(), st.data())
def test_a_damaged_message_is_read_or_refused(message: Message, data: st.DataObject) -> None:
    whole = bytearray(encode("a", message))
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(0, len(whole) - 1))
        whole[place] = data.draw(st.integers(0, 255))
    cut = data.draw(st.integers(0, len(whole)))
    with contextlib.suppress(WireError):
        decode(bytes(whole[:cut]))


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=5,
)


@patiently
@given(messages(), json_values, st.data())
def test_a_message_with_a_foreign_value_is_read_or_refused(
    message: Message, value: Any, data: st.DataObject
) -> None:
    envelope = json.loads(encode("a", message))
    field = data.draw(st.sampled_from(sorted(envelope["m"])))
    envelope["m"][field] = value
    try:
        sender, heard = decode(json.dumps(envelope).encode())
    except WireError:
        return
    assert decode(encode(sender, heard)) == (sender, heard)


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", "truncated"),
        (b"{", "truncated"),
        (b"[]", "Expected `object`"),
        (b'{"v":2,"from":"a"}', "missing required field `m`"),
        (b'{"v":2,"from":"a","m":{"type":"OrderTaken","order":"\xff"}}', "utf-8"),
        (b'{"v":2,"x":' + b"[" * 60_000, "recursion"),
        (wire({"type": "Nonsense"}), "Invalid value 'Nonsense'"),
        (wire({"type": "OrderTaken"}), "missing required field `order`"),
        (wire({"type": "OrderTaken", "order": 7}), "Expected `str`, got `int` - at `$.m.order`"),
        (wire(TAKEN, v="1"), "Expected `int`"),
        (wire(TAKEN, v=0), "wire version 0 was never spoken"),
        (wire(TAKEN, sender=None), "Expected `str`"),
        (b'{"v":2' + b"0" * 5000 + b',"from":"a","m":{}}', "out of range"),
    ],
    ids=lambda value: value[:40] if isinstance(value, str) else "",
)
def test_a_wire_error_says_what_did_not_fit(data: bytes, reason: str) -> None:
    with pytest.raises(WireError) as caught:
        decode(data)
    assert reason.lower() in caught.value.reason.lower()
    assert not isinstance(caught.value, NewerVersion)


@pytest.mark.parametrize("bad", ["", "a/b", "*", "a b", "a\n", "x" * 129, "a#b"])
def test_an_id_that_could_not_stand_in_a_key_is_refused(bad: str) -> None:
    with pytest.raises(WireError):
        decode(wire({"type": "OrderTaken", "order": bad}))
    with pytest.raises(WireError):
        decode(wire(TAKEN, sender=bad))


@pytest.mark.parametrize("quantity", [-1, 2**53 + 1, 1.5, True, "1"])
def test_a_quantity_that_cannot_be_carried_is_refused(quantity: object) -> None:
    assert decode(wire({"type": "Handover", "task": "t", "epoch": 1, "quantity": 5}))[1] == Handover(
        "t", 1, 5
    )
    with pytest.raises(WireError):
        decode(wire({"type": "Handover", "task": "t", "epoch": 1, "quantity": quantity}))


@pytest.mark.parametrize("due_s", ["NaN", "Infinity", "-Infinity", "1e999", "1e300", "null"])
def test_a_time_that_is_no_time_is_refused(due_s: str) -> None:
    order = '{"v":2,"from":"G","m":{"type":"OrderReleased","order":"o","items":[],"due_s":%s}}'
    assert decode((order % "1e3").encode())[1] == OrderReleased(order="o", items=(), due_s=1000.0)
    with pytest.raises(WireError):
        decode((order % due_s).encode())


def test_a_time_that_is_no_number_is_refused_by_the_peer() -> None:
    sick = OrderReleased(order="o", items=(), due_s=float("nan"))
    with pytest.raises(WireError):
        decode(encode("G", sick))


@pytest.mark.parametrize("v", [3, 17])
@pytest.mark.parametrize("message", [TAKEN, {"type": "FromTheFuture"}, {}])
def test_a_newer_wire_version_is_told_apart(v: int, message: dict[str, Any]) -> None:
    with pytest.raises(NewerVersion, match=f"wire version {v}"):
        decode(wire(message, v=v))


@pytest.mark.parametrize(
    "message",
    [
        {"type": "TableReplicated", "district": "M1", "epoch": 3, "version": 4},
        {"type": "TableReported", "district": "M1", "epoch": 3, "lost": False, "kept_epoch": 3, "version": 4},
    ],
    ids=lambda message: message["type"],
)
def test_a_table_with_a_line_under_a_number_that_it_has_not_given_is_refused(message: dict[str, Any]) -> None:
    lines = [{"place": "a", "number": 4, "atv": "A"}, {"place": "b", "number": 5, "atv": "A"}]
    decode(wire(message | {"reservations": lines[:1]}))
    with pytest.raises(WireError) as refused:
        decode(wire(message | {"reservations": lines}))
    assert "`number` 5 is above `version` 4 - at `$.reservations[1].number`" in str(refused.value)


def test_a_message_longer_than_the_bound_is_refused_unread() -> None:
    longest = wire({**TAKEN, "more": ""})
    padding = MAX_BYTES - len(longest)
    assert decode(wire({**TAKEN, "more": "x" * padding}))[1] == OrderTaken(order="o-1")
    with pytest.raises(WireError, match=f"{MAX_BYTES + 1} bytes"):
        decode(wire({**TAKEN, "more": "x" * (padding + 1)}))
