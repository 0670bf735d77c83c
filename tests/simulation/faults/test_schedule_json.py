"""Schedules of faults as JSON, and faults in words."""

from __future__ import annotations

import pytest
from fault_world import ONE_OF_EACH, PLANT

from dray_sim.faults import (
    Cast,
    FaultError,
    LinkTrouble,
    PoweredOff,
    Timed,
    WlanCut,
    describe,
    kind_of,
    read_fault,
    read_schedule,
    write_schedule,
)
from dray_sim.faults.kinds import KIND_NAMES, KINDS

CAST = Cast.of_plant(PLANT)


def test_there_is_an_example_of_each_kind() -> None:
    assert tuple(type(fault) for fault in ONE_OF_EACH) == KINDS
    assert tuple(kind_of(fault) for fault in ONE_OF_EACH) == KIND_NAMES


def test_a_schedule_comes_back_from_json_as_it_was() -> None:
    schedule = tuple(
        Timed(float(number), fault, number + 1.5 if number % 2 else None)
        for number, fault in enumerate(ONE_OF_EACH)
    )
    assert read_schedule(write_schedule(schedule), CAST) == schedule
    assert read_schedule(write_schedule(()), CAST) == ()


def test_a_single_fault_is_read_by_its_kind_and_defaults_may_be_left_out() -> None:
    assert read_fault('{"kind": "wlan_cut", "agent": "ATV3"}', CAST) == WlanCut("ATV3")
    assert read_fault(b'{"kind": "link_trouble", "loss_frac": 0.2}', CAST) == LinkTrouble(loss_frac=0.2)


TIMED = '[{"at_s": 1, "fault": {"kind": "wlan_cut", "agent": "ATV1"}}, {"at_s": 2, "fault": %s}]'


@pytest.mark.parametrize(
    ("data", "field", "said"),
    [
        ('[{"at_s": 1', "schedule", "truncated"),
        ("{}", "schedule", "Expected `array`"),
        (b"\xff\xff", "schedule", ""),
        ("[" * 100_000, "schedule[0]", "got `array`"),
        ("[]" + " " * 2_000_000, "schedule", "split it"),
        (
            '[{"fault": {"kind": "wlan_cut", "agent": "ATV1"}}]',
            "schedule[0]",
            "missing required field `at_s`",
        ),
        (TIMED % '{"agent": "ATV1"}', "schedule[1].fault", "missing required field `kind`"),
        (TIMED % '{"kind": "flood"}', "schedule[1].fault.kind", "the kinds are wlan_cut, radio_cut"),
        (TIMED % '{"kind": "wlan_cut"}', "schedule[1].fault", "missing required field `agent`"),
        (
            TIMED % '{"kind": "wlan_cut", "agent": "ATV99"}',
            "schedule[1].fault.agent",
            "there is no agent 'ATV99'",
        ),
        (TIMED % '{"kind": "wlan_cut", "agent": "*"}', "schedule[1].fault.agent", "regex"),
        (TIMED % '{"kind": "wlan_cut", "agent": "ATV1", "to": 1}', "schedule[1].fault", "unknown field `to`"),
        (TIMED % '{"kind": "link_trouble", "loss_frac": 1.1}', "schedule[1].fault.loss_frac", "<= 1.0"),
        (TIMED % '{"kind": "link_trouble", "latency_s": -1}', "schedule[1].fault.latency_s", ">= 0.0"),
        (TIMED % '{"kind": "link_trouble", "jitter_s": "1"}', "schedule[1].fault.jitter_s", "got `str`"),
        (TIMED % '{"kind": "link_trouble", "sender": ""}', "schedule[1].fault.sender", "length >= 1"),
        (TIMED % '{"kind": "partition", "groups": []}', "schedule[1].fault.groups", "length >= 1"),
        (TIMED % '{"kind": "partition", "groups": [[]]}', "schedule[1].fault.groups[0]", "length >= 1"),
        (
            TIMED % '{"kind": "coverage_hole", "x_m": 1, "y_m": 1, "radius_m": 0}',
            "schedule[1].fault.radius_m",
            "> 0.0",
        ),
        (
            '[{"at_s": 5, "until_s": 5, "fault": {"kind": "wlan_cut", "agent": "ATV1"}}]',
            "schedule[0].until_s",
            "let it end later",
        ),
        ('[{"at_s": -1, "fault": {"kind": "wlan_cut", "agent": "ATV1"}}]', "schedule[0].at_s", ">= 0.0"),
        ('[{"at_s": 1e300, "fault": {"kind": "wlan_cut", "agent": "ATV1"}}]', "schedule[0].at_s", "<="),
    ],
)
def test_what_is_no_schedule_is_told_with_its_place(data: str | bytes, field: str, said: str) -> None:
    with pytest.raises(FaultError) as caught:
        read_schedule(data, CAST)
    assert caught.value.field == field
    assert said in caught.value.reason


def test_a_fault_is_told_in_one_line_without_its_defaults() -> None:
    assert describe(LinkTrouble(sender="M1", loss_frac=0.2)) == "link trouble (sender='M1', loss_frac=0.2)"
    assert describe(PoweredOff("ATV3")) == "powered off (agent='ATV3')"
    assert describe(LinkTrouble()) == "link trouble ()"
    assert str(Timed(1.0, WlanCut("ATV1"), 2.5)) == "     1.0 s  wlan cut (agent='ATV1') until 2.5 s"
