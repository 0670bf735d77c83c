"""Signing keys: what one has granted is believed by whoever knows its public half, and by nobody else."""

from __future__ import annotations

from base64 import b64encode

import pytest
from msgspec import UNSET
from msgspec.structs import replace

from dray.adapters.security.signing import SigningKey, TrustedKeys
from dray.codec import decode, encode
from dray.messages import CommandKind, Removals, VehicleCommand, removed_words, reported_words, signed_words

COMMAND = VehicleCommand(command="C1", kind=CommandKind.SET_SPEED, speed_frac=1, issued_by="Überwacher")
OURS, THEIRS = SigningKey(bytes(32)), SigningKey(bytes(31) + b"1")


def granted(key: SigningKey) -> VehicleCommand:
    """Over the wire and back."""
    command = key.grant("ATV1", COMMAND, person="p1", areas=["AREA1"], valid_until_s=60)
    _, message = decode(encode("gateway", command))
    assert isinstance(message, VehicleCommand)
    return message


def believes(trusted: TrustedKeys, command: VehicleCommand, atv: str = "ATV1") -> bool:
    assert command.grant is not None
    return trusted(signed_words(atv, command, command.grant), command.grant.signature)


def test_a_grant_is_believed_after_its_way_over_the_wire() -> None:
    assert believes(TrustedKeys(OURS.public), granted(OURS))


def test_what_is_signed_holds_whole_numbers_alone() -> None:
    command = granted(OURS)
    assert command.grant is not None
    assert signed_words("ATV1", command, command.grant).decode() == (
        '["dray command 2","ATV1","C1","set_speed",1000,null,"Überwacher","p1",["AREA1"],false,60000]'
    )


@pytest.mark.parametrize(
    ("speed_frac", "thousandths"), [(0.1, 100), (0.3, 300), (1 / 3, 333), (0.0005, 1), (0.00049, 0)]
)
def test_a_number_is_signed_to_a_thousandth(speed_frac: float, thousandths: int) -> None:
    command = replace(COMMAND, speed_frac=speed_frac)
    grant = OURS.grant("ATV1", command, person="p1", areas=None, valid_until_s=60).grant
    assert grant is not None
    assert f',"set_speed",{thousandths},' in signed_words("ATV1", command, grant).decode()


def test_any_of_several_keys_counts() -> None:
    both = TrustedKeys(OURS.public, THEIRS.public)
    assert believes(both, granted(OURS))
    assert believes(both, granted(THEIRS))


def test_a_strangers_grant_is_not_believed() -> None:
    assert not believes(TrustedKeys(OURS.public), granted(THEIRS))
    assert not believes(TrustedKeys(), granted(OURS))


def test_a_grant_is_not_believed_by_another_vehicle() -> None:
    assert not believes(TrustedKeys(OURS.public), granted(OURS), atv="ATV2")


def test_a_grant_says_where() -> None:
    grant = OURS.grant("ATV1", COMMAND, person="p1", areas=["AREA1", "AREA2"], valid_until_s=60.0).grant
    assert grant is not None
    assert (grant.areas, grant.everywhere) == (("AREA1", "AREA2"), False)
    grant = OURS.grant("ATV1", COMMAND, person="p1", areas=None, valid_until_s=60.0).grant
    assert grant is not None
    assert (grant.areas, grant.everywhere) == ((), True)


def test_the_same_command_gets_the_same_signature() -> None:
    assert granted(OURS) == granted(OURS)


def test_new_keys_differ() -> None:
    assert SigningKey.generate() != SigningKey.generate()
    assert SigningKey(SigningKey.generate()).public != OURS.public


def test_what_is_no_key_is_refused() -> None:
    with pytest.raises(ValueError, match="32"):
        SigningKey(b"short")
    with pytest.raises(ValueError, match="32"):
        TrustedKeys(b"short")


def test_the_time_of_a_report_has_a_signature_of_its_own() -> None:
    """Agents that do not know it examine the rest as before."""
    said = OURS.remove(
        "ATV1",
        7,
        heard=(1, 2),
        node="",
        person="p1",
        areas=None,
        reported_s=12.5,
        now_s=14.0,
        valid_until_s=60.0,
    )
    _, message = decode(encode("gateway", Removals((said,))))
    assert isinstance(message, Removals)
    (removal,) = message.removals
    assert removal.reported is not UNSET
    words = reported_words(removal, removal.reported)
    grant = b64encode(removal.grant.signature).decode()
    assert words.decode() == f'["dray removal time 1","ATV1",7,"{grant}",12500,14000]'
    trusted = TrustedKeys(OURS.public)
    assert trusted(words, removal.reported.signature)
    assert not TrustedKeys(THEIRS.public)(words, removal.reported.signature)
    assert trusted(removed_words(replace(removal, reported=UNSET)), removal.grant.signature)
