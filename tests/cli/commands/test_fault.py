"""Faults by hand, from the command line to a simulated factory, and what is said when that fails."""

from __future__ import annotations

import socket
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest
from fake_gateway import FakeGateway

Run = Callable[..., tuple[int, str, str]]

KINDS = [
    {"kind": "wlan_cut", "what": "No WLAN.", "fields": ["agent"], "optional": []},
    {"kind": "vehicle_broken", "what": "A problem.", "fields": ["atv"], "optional": ["reason"]},
    {"kind": "link_trouble", "what": "Bad links.", "fields": [], "optional": ["latency_s"]},
]


@pytest.fixture
def run(call: Run, gateway: FakeGateway, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Run `dray fault ...` in this process: exit code, stdout, stderr."""
    monkeypatch.setenv("COLUMNS", "160")
    gateway.answers["GET /api/faults"] = (200, {"items": [], "kinds": KINDS})
    return partial(call, "fault")


def fault(name: str = "F1", **fields: Any) -> dict[str, Any]:
    return {"id": name, "kind": fields["kind"], "fault": fields, "agents": ["ATV3"], "began_at_s": 1.0}


def test_what_can_go_wrong_is_listed_with_its_fields(run: Run, gateway: FakeGateway) -> None:
    code, out, _ = run("list", "--url", gateway.url)
    assert code == 0
    assert "nothing is wrong" in out
    assert "vehicle_broken" in out
    assert "atv (reason)" in out


def test_what_is_wrong_is_listed_with_its_id(run: Run, gateway: FakeGateway) -> None:
    broken = fault(kind="vehicle_broken", atv="ATV3", reason="blocked")
    gateway.answers["GET /api/faults"] = (200, {"items": [broken], "kinds": KINDS})
    _, out, _ = run("list", "--url", gateway.url)
    line = next(line for line in out.splitlines() if "F1" in line)
    assert line.split() == ["F1", "vehicle_broken", "ATV3", "reason=blocked"]


@pytest.mark.parametrize("kind", ["vehicle_broken", "vehicle-broken", "VehicleBroken"])
def test_a_fault_is_begun_however_its_kind_is_spelt(run: Run, gateway: FakeGateway, kind: str) -> None:
    body = {"kind": "vehicle_broken", "atv": "ATV3", "reason": "the way is blocked"}
    gateway.answers["POST /api/faults"] = (201, fault(**body))
    code, out, err = run("begin", kind, "ATV3", "--set", "reason=the way is blocked", "--url", gateway.url)
    assert (code, out) == (0, "F1\n")
    assert err == "vehicle_broken of ATV3 (reason=the way is blocked) has begun, until `dray fault end F1`\n"
    assert gateway.asked[-1] == ("POST", "/api/faults", body)


def test_numbers_are_sent_as_numbers(run: Run, gateway: FakeGateway) -> None:
    gateway.answers["POST /api/faults"] = (201, fault(kind="link_trouble", latency_s=2.5))
    assert run("begin", "link-trouble", "--set", "latency_s=2.5", "--url", gateway.url)[0] == 0
    assert gateway.asked[-1][2] == {"kind": "link_trouble", "latency_s": 2.5}


def test_a_person_on_a_lane_goes_on_by_themselves_and_that_is_said(run: Run, gateway: FakeGateway) -> None:
    kinds = [{"kind": "lane_blocked", "what": "", "fields": ["start", "end"], "optional": ["thing"]}]
    gateway.answers["GET /api/faults"] = (200, {"items": [], "kinds": kinds})
    body = {"kind": "lane_blocked", "start": "a1", "end": "b1", "thing": "person"}
    gateway.answers["POST /api/faults"] = (201, fault(**body) | {"agents": []})
    given = [part for name in ("start", "end", "thing") for part in ("--set", f"{name}={body[name]}")]
    _, out, err = run("begin", "lane-blocked", *given, "--url", gateway.url)
    assert out == "F1\n"
    assert err.startswith("lane_blocked (start=a1 end=b1 thing=person) has begun, until the person goes on")


def test_a_fault_is_ended(run: Run, gateway: FakeGateway) -> None:
    gateway.answers["DELETE /api/faults/F1"] = (200, fault(kind="wlan_cut", agent="ATV3"))
    code, out, _ = run("end", "F1", "--url", gateway.url)
    assert (code, out) == (0, "wlan_cut of ATV3 has ended; it began at 00:00:01 UTC\n")
    assert gateway.asked == [("DELETE", "/api/faults/F1", None)]


@pytest.mark.parametrize(
    ("args", "says"),
    [
        (("begin", "fly", "ATV3"), "wlan_cut"),
        (("begin", "wlan_cut"), "AGENT"),
        (("begin", "link_trouble", "ATV3"), "--set"),
        (("begin", "wlan_cut", "ATV3", "--set", "reason"), "field=value"),
    ],
)
def test_input_that_cannot_be_used_is_refused_before_anything_is_begun(
    run: Run, gateway: FakeGateway, args: tuple[str, ...], says: str
) -> None:
    code, out, err = run(*args, "--url", gateway.url)
    assert (code, out) == (2, "")
    assert says in err
    assert not [method for method, _, _ in gateway.asked if method == "POST"]


def test_an_unknown_agent_is_named_in_the_gateways_words(run: Run, gateway: FakeGateway) -> None:
    errors = [{"field": "agent", "reason": "there is no agent 'ATV99'; give one of ATV1, ATV2"}]
    gateway.answers["POST /api/faults"] = (422, {"detail": "first", "errors": errors})
    code, _, err = run("begin", "wlan_cut", "ATV99", "--url", gateway.url)
    assert code == 2
    assert err == "dray: agent: there is no agent 'ATV99'; give one of ATV1, ATV2\n"


def test_an_unknown_fault_is_refused(run: Run, gateway: FakeGateway) -> None:
    gateway.answers["DELETE /api/faults/F9"] = (404, {"detail": "no fault has the id 'F9'"})
    code, _, err = run("end", "F9", "--url", gateway.url)
    assert (code, err) == (2, "dray: no fault has the id 'F9'\n")


def test_a_factory_that_is_not_simulated_is_said(run: Run, gateway: FakeGateway) -> None:
    gateway.answers["GET /api/faults"] = (409, {"detail": "only in a simulated factory"})
    code, _, err = run("list", "--url", gateway.url)
    assert code == 1
    assert "only in a simulated factory" in err


@pytest.mark.parametrize("answer", [(200, b"<html>"), (200, {"items": 7}), (500, b"<html>")])
def test_a_server_that_is_not_dray_is_said(run: Run, gateway: FakeGateway, answer: tuple[int, Any]) -> None:
    gateway.answers["GET /api/faults"] = answer
    code, _, err = run("list", "--url", gateway.url)
    assert code == 1
    assert gateway.url in err
    assert "Traceback" not in err


def test_nobody_there_is_said_with_a_remedy(run: Run) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    code, _, err = run("list", "--url", f"http://127.0.0.1:{port}")
    assert code == 1
    assert err.count("\n") == 1
    assert "dray up" in err


@pytest.mark.parametrize("url", ["ftp://x", "127.0.0.1:8000", "http://", "http://[zz", "http://x:99999"])
def test_what_is_no_address_is_refused(run: Run, url: str) -> None:
    code, _, err = run("list", "--url", url)
    assert code == 2
    assert err.startswith("dray: --url: ")


@pytest.mark.slow
def test_a_vehicle_of_a_running_factory_is_switched_off_and_on(
    run: Run, start_dray: Callable[..., Any]
) -> None:
    dray = start_dray("--speed", "20", "--no-demand")
    asked = ("--url", dray.url, "--token", dray.token)
    code, out, err = run("begin", "powered-off", "ATV3", *asked)
    assert (code, err) == (
        0,
        f"powered_off of ATV3 has begun, until `dray fault end {out.strip()}`\n",
    )
    assert out.strip() in run("list", *asked)[1]
    code, _, err = run("begin", "load-shifted", "ATV1", *asked)
    assert code == 2
    assert "ATV1 has no load" in err
    assert run("end", out.strip(), *asked)[0] == 0
    assert "nothing is wrong" in run("list", *asked)[1]
    assert dray.stop() == 0, dray.output()
