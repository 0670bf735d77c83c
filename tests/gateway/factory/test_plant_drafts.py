"""Drafts of plants over REST: kept with a version, judged as `dray plant check` does, and played by a process of its own."""

from __future__ import annotations

import asyncio
import base64
import copy
import gzip
import io
import json
import sys
from pathlib import Path
from string import Formatter
from typing import Any

import ezdxf
import httpx
import msgspec
import pytest
from answers import problem
from gateway_kit import House
from side_work_kit import count_pieces

from dray.gateway.access.principal import Role, Scope
from dray.gateway.factory.dxf_plans import DxfPlans, NoPlan
from dray.gateway.factory.plant_drafts import as_file, findings
from dray.gateway.factory.shift_player import PlayView, ShiftPlayer
from dray.gateway.http.problems import Problem
from dray.gateway.routes.factory.plant_draft_work import KeptDraft, draft_view
from dray.plant import default_plant, load_plant, plant_yaml
from dray.plant.exchange.dxf import MAX_BYTES
from dray.plant.exchange.lif_export import export_lif
from dray.plant.file.reasons import PLAYED_TEXTS
from dray.store.factory.plant_drafts import DraftRow

pytestmark = pytest.mark.anyio


async def begin(house: House, **fields: Any) -> dict[str, Any]:
    answer = await house.client.post("/api/plant-drafts", json={"name": "Line 4", **fields})
    assert answer.status_code == 201, answer.text
    return answer.json()  # type: ignore[no-any-return]


async def change(house: House, draft: dict[str, Any], version: int | None = None, **fields: Any) -> Any:
    headers = {"If-Match": f'"{version or draft["version"]}"'} if version != 0 else {}
    body = {"name": draft["name"], "data": draft["data"], **fields}
    return await house.client.put(f"/api/plant-drafts/{draft['id']}", json=body, headers=headers)


async def test_a_draft_begins_with_the_running_plant_and_is_kept_with_its_version(house: House) -> None:
    draft = await begin(house)
    assert draft["version"] == 1
    assert {each["level"] for each in draft["findings"]} <= {"warning"}
    path = f"/api/plant-drafts/{draft['id']}"
    seen = await house.client.get(path)
    assert seen.headers["ETag"].removeprefix("W/").startswith('"1/')
    again = {"If-None-Match": seen.headers["ETag"]}
    assert (await house.client.get(path, headers=again)).status_code == 304
    lanes = draft["data"]["lanes"]
    answer = await change(house, draft, data={**draft["data"], "lanes": [*lanes, lanes[0]]})
    assert answer.json()["version"] == 2
    assert answer.headers["ETag"].removeprefix("W/") == '"2"'
    faults = {each["field"] for each in answer.json()["findings"] if each["level"] == "error"}
    assert faults == {f"lanes[{len(lanes)}]"}
    listed = await house.get("/api/plant-drafts")
    assert [(each["id"], each["version"]) for each in listed["items"]] == [(draft["id"], 2)]
    running = await house.get("/api/plant-drafts/running")
    assert running["nodes"] == draft["data"]["nodes"]


async def test_many_who_read_one_draft_cost_one_rendering_of_each_version(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    draft = await begin(house)
    readers = [(await house.key(Scope.FACTORY_READ))[1] for _ in range(6)]
    pieces = count_pieces(monkeypatch)

    async def read(tail: str = "") -> set[str]:
        path = f"/api/plant-drafts/{draft['id']}{tail}"
        answers = await asyncio.gather(*(house.client.get(path, headers=reader) for reader in readers))
        assert {answer.status_code for answer in answers} == {200}
        return {answer.text for answer in answers}

    [file], [view] = await read("/file"), await read()
    assert f"plant: {draft['data']['plant']}" in file
    assert json.loads(view) == draft
    # The answer to whoever has made it is kept for the others.
    assert len(pieces) == 1
    changed = (await change(house, draft, data={**draft["data"], "name": "Line 5"})).json()
    pieces.clear()
    [file], [view] = await read("/file"), await read()
    assert "Line 5" in file
    assert json.loads(view) == changed
    assert len(pieces) == 1


async def test_of_two_who_change_one_draft_the_second_is_told(house: House) -> None:
    draft = await begin(house)
    assert (await change(house, draft, version=0)).status_code == 428
    answers = await asyncio.gather(*(change(house, draft, name=name) for name in ("one", "two", "three")))
    assert sorted(answer.status_code for answer in answers) == [200, 412, 412]
    late = await change(house, draft)
    assert late.status_code == 412
    assert late.json()["type"] == "urn:dray:problem:draft-changed"


async def test_a_layout_is_read_and_what_it_lacks_is_open_or_taken_from_the_running_plant(
    house: House,
) -> None:
    lif = export_lif(default_plant(), "2026-11-23T08:00:00Z")
    alone = await begin(house, file=lif, file_name="hall.json")
    assert {"machines", "fleet", "unassigned[0]"} <= {each["field"] for each in alone["findings"]}
    assert {each["level"] for each in alone["findings"]} == {"open"}
    assert any("actions" in note["text"] and note["code"] for note in alone["notes"])
    onto = await begin(house, file=lif, file_name="hall.json", onto_running=True)
    assert onto["data"]["machines"] == (await begin(house))["data"]["machines"]
    bad = await house.client.post("/api/plant-drafts", json={"name": "x", "file": "{}"})
    assert bad.status_code == 422
    assert bad.json()["errors"][0]["field"] == "file"
    text = await house.client.get(f"/api/plant-drafts/{onto['id']}/file")
    assert text.headers["content-type"].startswith("application/yaml")
    assert text.headers["content-disposition"] == f'attachment; filename="{onto["data"]["plant"]}.yaml"'
    odd = (await change(house, onto, data={**onto["data"], "plant": 'a"b'})).json()
    text = await house.client.get(f"/api/plant-drafts/{odd['id']}/file")
    assert text.headers["content-disposition"] == f'attachment; filename="{odd["id"]}.yaml"'


async def test_what_no_draft_can_be_is_refused(house: House) -> None:
    draft = await begin(house)
    deep: Any = []
    for _ in range(20):
        deep = [deep]
    assert (await change(house, draft, data={"nodes": deep})).status_code == 422
    assert (await change(house, draft, data={})).status_code == 200
    assert (await house.client.get("/api/plant-drafts/none")).status_code == 404
    assert (await house.client.delete("/api/plant-drafts/none")).status_code == 404
    assert (await house.client.delete(f"/api/plant-drafts/{draft['id']}")).status_code == 204
    assert (await change(house, draft)).status_code == 404


async def test_a_floor_plan_is_kept_and_does_nothing_by_itself(house: House) -> None:
    draft = await begin(house)
    path = f"/api/plant-drafts/{draft['id']}/plan"
    svg = b'<svg xmlns="http://www.w3.org/2000/svg"><script>alert(1)</script></svg>'
    body = {"media_type": "image/svg+xml", "base64": base64.b64encode(svg).decode()}
    told = problem(await house.client.get(path), 404, "unknown-plan")
    assert told["detail"] == f"nothing lies under draft {draft['id']}; PUT {path} lays a picture there"
    problem(await house.client.get("/api/plant-drafts/none/plan"), 404, "unknown-draft")
    laid = await house.client.put(path, json=body)
    assert (laid.status_code, laid.json()["width_m"]) == (200, None)
    seen = await house.client.get(path)
    assert seen.content == svg
    assert "default-src 'none'" in seen.headers["Content-Security-Policy"]
    for wrong in ({"media_type": "text/html"}, {"media_type": "image/png"}, {"base64": "%"}):
        assert (await house.client.put(path, json={**body, **wrong})).status_code == 422


def dxf_plan(length_mm: int) -> bytes:
    document = ezdxf.new()
    document.header["$INSUNITS"] = 4
    document.modelspace().add_lwpolyline([(0, 0), (length_mm, 0), (length_mm, 9000)])
    stream = io.StringIO()
    document.write(stream)
    return stream.getvalue().encode()


async def test_a_floor_plan_in_dxf_becomes_a_picture_as_large_as_it_says(house: House) -> None:
    draft = await begin(house)
    path = f"/api/plant-drafts/{draft['id']}/plan"

    async def lay(content: bytes) -> httpx.Response:
        body = {"media_type": "image/vnd.dxf", "base64": base64.b64encode(content).decode()}
        return await house.client.put(path, json=body)

    for content, metres in ((dxf_plan(30_000), 30), (gzip.compress(dxf_plan(40_000)), 40)):
        answer = await lay(content)
        assert answer.status_code == 200, answer.text
        laid = answer.json()
        assert (laid["media_type"], laid["width_m"], laid["height_m"]) == ("image/svg+xml", metres, 9.0)
        seen = await house.client.get(path)
        assert seen.headers["Content-Type"].startswith("image/svg+xml")
        assert f"M0 9000l{metres}000 0 0 -9000" in seen.text
    wrong = await lay(b"AC1032 dwg")
    assert wrong.status_code == 422
    assert "plan.dxf: it is DWG: save it as DXF" in wrong.text
    assert (await house.client.get(path)).content == seen.content


async def test_reading_a_floor_plan_has_bounds() -> None:
    bomb = gzip.compress(bytes(MAX_BYTES + 1))
    for content, why in (
        (bomb, "unpacked it has more than"),
        (gzip.compress(b"x" * 999)[:-9], "its end is missing"),
        (b"\x1f\x8b nonsense", "packed badly"),
    ):
        with pytest.raises(NoPlan, match=why):
            await DxfPlans().picture(content)
    waits = (sys.executable, "-c", "import threading; threading.Event().wait()")
    with pytest.raises(NoPlan, match=r"longer than 0\.2 s"):
        await DxfPlans(waits, most_s=0.2).picture(b"x")
    plans = DxfPlans(waits)
    first = asyncio.create_task(plans.picture(b"x"))
    await asyncio.sleep(0)
    with pytest.raises(Problem, match="Another floor plan"):
        await plans.picture(b"x")
    first.cancel()
    await asyncio.gather(first, return_exceptions=True)


async def test_people_of_the_floor_may_not_draw(house: House) -> None:
    operator = await house.log_in("olga", Role.OPERATOR, "AREA1")
    assert (await operator.get("/api/plant-drafts")).status_code == 403
    assert (await operator.post("/api/plant-drafts", json={"name": "x"})).status_code == 403


async def test_a_draft_with_faults_is_not_played(house: House) -> None:
    draft = await begin(house)
    assert (await change(house, draft, data={**draft["data"], "machines": None})).status_code == 200
    answer = await house.client.post(f"/api/plant-drafts/{draft['id']}/play", json={})
    assert answer.status_code == 422
    assert answer.json()["errors"][0]["field"] == "data.machines"
    assert (await house.get(f"/api/plant-drafts/{draft['id']}/play"))["state"] == "none"


def test_closed_lanes_are_not_part_of_the_file_and_findings_are_those_of_the_draft() -> None:
    plant = load_plant("workshop").file
    data = {
        "lanes": [{"start": "a", "end": "b"}, {"start": "b", "end": "a"}, {"start": "b", "end": "b"}],
        "nodes": [{"id": "a", "x_m": 1, "y_m": 1}, {"id": "b", "x_m": 9, "y_m": 1}],
        "closed": [{"start": "a", "end": "b"}],
        "plan": {"x_m": 0},
    }
    file, kept = as_file(data)
    assert kept["lanes"] == [1, 2]
    assert "closed" not in file
    assert "plan" not in file
    full: dict[str, Any] = {**_builtins(plant), "closed": [], "nodes": _builtins(plant)["nodes"]}
    full["lanes"] = [*full["lanes"], {"start": "in", "end": "in"}]
    full["closed"] = [{"start": full["lanes"][0]["start"], "end": full["lanes"][0]["end"]}]
    assert f"lanes[{len(full['lanes']) - 1}].end" in {each.field for each in findings(full)}


def _builtins(value: object) -> dict[str, Any]:
    return msgspec.to_builtins(value)  # type: ignore[no-any-return]


SCRIPT = """
import json, sys
report = sys.argv[sys.argv.index("--json") + 1]
{body}
"""

REPORT = {
    "orders_placed": 4,
    "orders_due": 0,
    "orders_delivered": 3,
    "on_time_frac": 0.0,
    "starvation_frac": 0.1,
    "transports": 30,
    "duration_s": 1800.0,
    "utilisation_frac": {"waiting": 0.2},
    "empty_travel_frac": 0.5,
    "invariants": "held",
    "verdict": {
        "bottleneck": "machine",
        "name": "M1",
        "text": "too few",
        "code": "played_few_machines",
        "values": {"machine": "M1"},
    },
}


async def as_given(text: str) -> str:
    return text


async def played(tmp_path: Path, body: str, most_s: float = 60.0) -> PlayView:
    script = tmp_path / "simulator.py"
    script.write_text(SCRIPT.format(body=body), encoding="utf-8")
    player = ShiftPlayer(lambda: as_given("running"), (sys.executable, str(script)), most_s)
    player.play("d", "text", 3, 1.0, 1)
    with pytest.raises(Problem, match="being played"):
        player.play("e", "text", 1, 1.0, 1)
    assert player._task is not None
    await player._task
    return player.result("d")


async def test_a_shift_is_played_in_the_draft_and_in_the_running_plant(tmp_path: Path) -> None:
    view = await played(tmp_path, f"json.dump({REPORT!r}, open(report, 'w'))")
    assert view.state == "done"
    assert view.version == 3
    assert view.draft == view.running
    assert view.draft is not None
    assert (view.draft.transports_per_h, view.draft.on_time_frac) == (60.0, None)
    assert (view.draft.bottleneck_code, view.draft.bottleneck_values) == (
        "played_few_machines",
        {"machine": "M1"},
    )


async def test_a_simulator_that_fails_or_hangs_is_said(tmp_path: Path) -> None:
    failed = await played(tmp_path, "sys.exit('the simulator is not installed')")
    assert (failed.state, failed.reason) == ("failed", "the simulator is not installed")
    garbled = await played(tmp_path, "open(report, 'w').write('[]')")
    assert (garbled.reason, garbled.reason_code) == ("the simulator gave no report", "played_no_report")
    assert failed.reason_code == ""
    slow = await played(tmp_path, "import threading; threading.Event().wait()", most_s=0.2)
    assert "longer than 0.2 s" in slow.reason
    assert (slow.reason_code, slow.reason_values) == ("played_too_long", {"most_s": 0.2})


@pytest.mark.slow
async def test_the_real_simulator_plays_a_short_shift() -> None:
    text = plant_yaml(load_plant("workshop"))
    player = ShiftPlayer(lambda: as_given(text))
    player.play("d", text, 1, 0.1, 1)
    assert player._task is not None
    await player._task
    view = player.result("d")
    assert view.state == "done", view.reason
    assert view.draft == view.running
    assert view.draft is not None
    assert view.draft.bottleneck_code in PLAYED_TEXTS
    begins = PLAYED_TEXTS[view.draft.bottleneck_code].partition("{")[0]
    assert view.draft.bottleneck.startswith(begins)
    filled = {name for _, name, _, _ in Formatter().parse(PLAYED_TEXTS[view.draft.bottleneck_code]) if name}
    assert view.draft.bottleneck_values.keys() == filled


def test_a_door_stands_on_the_lanes_that_are_driven_in_the_draft() -> None:
    data: dict[str, Any] = msgspec.json.decode(msgspec.json.encode(default_plant().file))
    on = {"start": "c2", "end": "c3"}
    door = {"id": "D1", "name": "Gate", "lanes": [on], "opening_s": 8.0, "closes_after_s": 5.0}
    data["doors"] = [door, {**door, "id": "D2", "lanes": [{"start": "d2", "end": "d3"}]}, "no door"]
    assert as_file(data)[0]["doors"] == data["doors"]
    file = as_file({**data, "closed": [on]})[0]
    assert file["doors"] == data["doors"][1:]
    data["doors"].pop()
    assert not [each for each in findings({**data, "closed": []}) if each.level == "error"]


def test_a_finding_has_a_code_and_what_is_filled_in_named_as_in_the_draft() -> None:
    data = _builtins(load_plant("workshop").file)
    first = data["lanes"][0]
    data["lanes"] = [*data["lanes"], first]
    # With a closed lane before them the lanes of the plant file have other numbers than those of the draft.
    closed = {"start": "nowhere", "end": first["start"], "speed_limit_mps": 1.0}
    data["lanes"].insert(0, closed)
    data["closed"] = [{"start": "nowhere", "end": first["start"]}]
    told = findings(data)[0]
    assert (told.code, told.level) == ("lane_twice", "error")
    assert told.values == {"first": "lanes[1]", "start": first["start"], "end": first["end"]}
    assert told.text.startswith("lanes[1] leads from ")
    near = copy.deepcopy(_builtins(load_plant("workshop").file))
    near["machines"][0]["node"] = "nowhere"
    unknown = findings(near)[0]
    assert unknown.code == "plant_unknown"
    assert unknown.values["advice"]["code"] in ("did_you_mean", "add_or_other")
    assert unknown.values["advice"]["text"] in unknown.text


def test_a_draft_from_before_findings_had_codes_keeps_its_notes() -> None:
    row = DraftRow("d", "Old", 1, "Maria", 0.0, "{}", '["/nodes/0: odd"]', owner="key-1")
    told = msgspec.json.decode(draft_view(KeptDraft.of(row)))["notes"]
    assert [(note["text"], note["code"]) for note in told] == [("/nodes/0: odd", "")]


def test_findings_of_doors_are_those_of_the_draft_whatever_is_closed_before_them() -> None:
    data: dict[str, Any] = msgspec.json.decode(msgspec.json.encode(default_plant().file))
    away = {"start": "c2", "end": "c3"}
    both = [{"start": "c3", "end": "c2"}, {"start": "d2", "end": "nowhere"}]
    door = {"id": "D1", "name": "Gate", "lanes": [away], "opening_s": 8.0, "closes_after_s": 5.0}
    data["doors"] = [door, {**door, "id": "D2", "lanes": both}, {**door, "id": "D3", "opening_s": 8000.0}]
    data["doors"][2]["lanes"] = [{"start": "d2", "end": "d3"}]
    data["doors"].append({**data["doors"][2], "lanes": [{"start": "b2", "end": "b3"}], "opening_s": 8.0})
    expected = (
        ("doors[1].lanes[1]", "no lane joins d2 and nowhere"),
        ("doors[2].opening_s", "8000 is not within"),
        ("doors[3].id", "D3 is the id of doors[2] already"),
    )
    for closed in ([], [away]):
        told = [(each.field, each.text) for each in findings({**data, "closed": closed})]
        for field, text in expected:
            assert [said for where, said in told if where == field and text in said], (closed, told)


def test_of_two_one_way_lanes_the_one_that_is_driven_keeps_its_door() -> None:
    there, back = {"start": "a", "end": "b"}, {"start": "b", "end": "a"}
    data = {"lanes": [there, back], "doors": [{"id": "D1", "lanes": [there, back]}], "closed": [there]}
    assert as_file(data)[0]["doors"] == [{"id": "D1", "lanes": [back]}]


async def test_a_layout_in_another_unit_and_encoding_is_asked_about_and_read(house: House) -> None:
    types = [{"vehicleTypeId": "t", "maxSpeed": 800}]
    nodes = [
        {"nodeId": name, "nodePosition": {"x": x, "y": 0}, "vehicleTypeNodeProperties": types[:0]}
        for name, x in (("Prüfplatz", 0), ("b", 400))
    ]
    edges = [
        {"edgeId": "e", "startNodeId": "Prüfplatz", "endNodeId": "b", "vehicleTypeEdgeProperties": types}
    ]
    text = json.dumps({"layouts": [{"layoutId": "L", "nodes": nodes, "edges": edges}]}, ensure_ascii=False)
    file = {"name": "d", "file_base64": base64.b64encode(text.encode("cp1252")).decode()}
    refused = problem(await house.client.post("/api/plant-drafts", json=file), 422, "unusable-fields")
    assert "mm (times 0.001: edges of 0.4 m, 0.8 m/s)" in refused["errors"][0]["reason"]
    read = (await house.client.post("/api/plant-drafts", json={**file, "unit": "mm"})).json()
    assert [node["x_m"] for node in read["data"]["nodes"]] == [0.0, 0.4]
    assert read["data"]["lanes"][0]["speed_limit_mps"] == 0.8
    assert any("read as windows-1252" in note["text"] for note in read["notes"])
