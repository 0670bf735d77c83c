"""`dray vehicle status`: how vehicles are, and in the last line what each waits for."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest
from fake_gateway import FakeGateway

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(call: Run) -> Run:
    """Run `dray vehicle status ...` in this process: exit code, stdout, stderr."""
    return partial(call, "vehicle", "status")


def vehicle(atv: str, **more: Any) -> dict[str, Any]:
    seen_at_s = time.time() - 2.0
    usual = {"id": atv, "status": "working", "node": "b1", "battery_frac": 0.82, "seen_at_s": seen_at_s}
    return usual | {"load": "", "load_quantity": 0, "problem": "", "body_wait": None} | more


def test_the_last_line_says_what_it_waits_for_since_when_and_what_would_end_it(
    run: Run, gateway: FakeGateway
) -> None:
    since_s = time.time() - 90.5
    wait = {"what": "it is paused", "until": "that is gone", "since_at_s": since_s}
    told = vehicle("ATV3", problem="it is paused", load="shaft", load_quantity=20, body_wait=wait)
    gateway.answers["GET /api/atvs/ATV3"] = (200, told)
    code, out, _ = run("ATV3", "--url", gateway.url)
    first, problem, last = out.splitlines()
    assert code == 0
    assert first.startswith("ATV3: working at b1, battery 82 %, 20 x shaft; heard ")
    assert problem == "    problem: it is paused"
    wait_s = re.fullmatch(r"    waits for (\d+) s: it is paused \(until that is gone\)", last)
    assert wait_s is not None, last
    assert 90 <= int(wait_s[1]) <= time.time() - since_s + 1


def test_all_vehicles_are_told_page_by_page(run: Run, gateway: FakeGateway) -> None:
    gateway.answers["GET /api/atvs?limit=100"] = (200, {"items": [vehicle("ATV1")], "next_cursor": "a/b"})
    gateway.answers["GET /api/atvs?limit=100&cursor=a%2Fb"] = (
        200,
        {"items": [vehicle("ATV2")], "next_cursor": None},
    )
    code, out, _ = run("--url", gateway.url)
    assert code == 0
    assert [line[:4] for line in out.splitlines()[::2]] == ["ATV1", "ATV2"]
    assert out.count("waits for nothing that it tells") == 2


def test_a_level_that_is_reckoned_is_told_as_such(run: Run, gateway: FakeGateway) -> None:
    gateway.answers["GET /api/atvs/ATV3"] = (200, vehicle("ATV3", battery_reckoned=True))
    assert "battery about 82 %" in run("ATV3", "--url", gateway.url)[1]


def test_a_vehicle_that_is_not_there_is_said(run: Run, gateway: FakeGateway) -> None:
    gateway.answers["GET /api/atvs/ATV9"] = (404, {"detail": "there is no atv ATV9"})
    code, _, err = run("ATV9", "--url", gateway.url)
    assert code != 0
    assert "there is no atv ATV9" in err
