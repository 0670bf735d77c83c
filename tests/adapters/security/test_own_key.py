"""A vehicle's own key: drawn once, kept beside its journal, and told from any other."""

from __future__ import annotations

from pathlib import Path
from stat import S_IMODE

import pytest
from msgspec.structs import replace

from dray.adapters.security.own_key import own_key
from dray.adapters.security.signing import VehicleKey, is_signed
from dray.errors import UnavailableError
from dray.messages import PlaceRequested
from dray.messages.radio import AVOID_NODES, shortened_word

REQUEST = PlaceRequested(
    district="M4",
    life=1,
    seq=1,
    epoch=0,
    rank=(0, 1.2345, "ATV1"),
    holds=("b3",),
    groups=(("b4",),),
    seen=7,
    stands=True,
    docked=False,
)


def test_a_key_is_drawn_once_and_read_by_its_owner_alone(tmp_path: Path) -> None:
    file = tmp_path / "journals" / "ATV1.key"
    first = own_key(file)
    assert own_key(file) == first
    assert own_key(tmp_path / "ATV2.key") != first
    assert S_IMODE(file.stat().st_mode) == 0o600


@pytest.mark.parametrize("left", [b"", b"short", b"k" * 33])
def test_a_key_that_is_not_whole_is_said_and_not_replaced(tmp_path: Path, left: bytes) -> None:
    file = tmp_path / "ATV1.key"
    file.write_bytes(left)
    with pytest.raises(UnavailableError, match="move it away"):
        own_key(file)
    assert file.read_bytes() == left


def test_a_request_is_signed_whole_and_in_one_name() -> None:
    signed = VehicleKey("ATV1", b"o" * 32).sign(REQUEST)
    assert is_signed("ATV1", signed)
    assert not is_signed("ATV2", signed)
    changes: list[dict[str, object]] = [
        {"district": "M5"},
        {"life": 2},
        {"seq": 2},
        {"epoch": 3},
        {"rank": (0, 1.3, "ATV1")},
        {"holds": ()},
        {"groups": ()},
        {"seen": 8},
        {"stands": False},
        {"docked": True},
        {"chain": ("ATV3",)},
        {"removal": 1},
        {"signature": b""},
        {"key": VehicleKey("ATV1", b"s" * 32).sign(REQUEST).key},
        {"key": b"no key"},
    ]
    assert not any(is_signed("ATV1", replace(signed, **change)) for change in changes)


def test_a_request_that_is_cut_for_the_radio_is_still_signed() -> None:
    request = replace(REQUEST, avoid=tuple(f"r{number}" for number in range(64)))
    signed = VehicleKey("ATV1", b"o" * 32).sign(request)
    cut = list(shortened_word(signed))
    assert [len(each.avoid) for each in cut if isinstance(each, PlaceRequested)] == [64, *AVOID_NODES]
    assert all(isinstance(each, PlaceRequested) and is_signed("ATV1", each) for each in cut)


def test_a_request_without_a_key_is_nobodys_in_particular() -> None:
    assert is_signed("ATV1", REQUEST)
