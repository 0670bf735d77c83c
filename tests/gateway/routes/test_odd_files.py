"""No file, however odd or broken, is answered by a bug: it is read, or refused with what is wrong with it."""

from __future__ import annotations

import base64
import json
from contextlib import suppress
from typing import Any

import pytest
from gateway_kit import House
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dray.errors import PlantError
from dray.plant.exchange.read import read_layout

pytestmark = pytest.mark.anyio

HUGE = 10**400


@pytest.fixture
def house(quiet_house: House) -> House:
    return quiet_house


def xml(body: str, head: str = "") -> str:
    return f'{head}<model version="0.0.4" name="hall">{body}</model>'


def lif(x: Any = 0, **edge: Any) -> str:
    """A layout of two nodes, one of which lies at `x`."""
    types = [{"vehicleTypeId": "t"}]
    nodes = [
        {"nodeId": name, "nodePosition": {"x": at, "y": 0}, "vehicleTypeNodeProperties": types}
        for name, at in (("a", x), ("b", 5))
    ]
    edges = [
        {
            "edgeId": "e",
            "startNodeId": "a",
            "endNodeId": "b",
            "vehicleTypeEdgeProperties": [{**types[0], **edge}],
        }
    ]
    return json.dumps({"metaInformation": {}, "layouts": [{"layoutId": "l", "nodes": nodes, "edges": edges}]})


def point(name: str, x: object = 0) -> str:
    return f'<point name="{name}" xPosition="{x}" yPosition="0" type="HALT_POSITION"/>'


CURVE = {"degree": 3, "knotVector": [0, 0, 0, 0, 1, 1, 1, 1]}

ODD_TEXTS = {
    "empty": "",
    "blank": " \n\t",
    "nul": "\0\0\0\0",
    "surrogate": "\ud800",
    "surrogate in YAML": "plant: p\nname: \ud800",
    "surrogate in XML": xml(point("\ud800")),
    "surrogate in JSON": lif().replace('"a"', '"\\ud800"'),
    "replaced": xml(point("Pr\ufffdfplatz") + point("b", 5000)),
    "no list": "{}",
    "list": "[]",
    "JSON NaN": lif(float("nan")),
    "JSON Infinity": lif(float("inf")),
    "JSON large": lif(1e308),
    "JSON huge": lif(HUGE),
    "JSON speed": lif(maxSpeed=1e308),
    "JSON long": lif(maxSpeed="9" * 5000),
    "JSON degree": lif(trajectory={"degree": 1e308, "controlPoints": [], "knotVector": []}),
    "JSON far curve": lif(
        trajectory={**CURVE, "controlPoints": [{"x": x, "y": x} for x in (0, 1e300, -1e300, 5)]}
    ),
    "JSON heavy curve": lif(
        trajectory={**CURVE, "controlPoints": [{"x": x, "y": 0, "weight": 1e-320} for x in (0, 1, 2, 5)]}
    ),
    "JSON knots": lif(trajectory={"degree": 1, "knotVector": {"a": 1}, "controlPoints": [1, None]}),
    "JSON nested": "{" * 5000,
    "JSON nested lists": '{"layouts":' + "[" * 5000,
    "JSON of other kinds": '{"layouts": {"a": 1}, "metaInformation": []}',
    "JSON nothing": '{"layouts": [null, 1, {"nodes": [null, {"nodeId": {}, "nodePosition": []}], "edges": 5}]}',
    "JSON kept": lif(note=HUGE, other=1e300),
    "JSON origins": '{"origins": 5, "metaInformation": {"lifVersion": {}}}',
    "JSON twice": '{"layouts": [], "layouts": 5}',
    "XML ANSI": xml(point("ü"), '<?xml version="1.0" encoding="ANSI"?>'),
    "XML unicode": xml(point("ü"), '<?xml version="1.0" encoding="unicode"?>'),
    "XML claims UTF-16": xml(point("ü"), '<?xml version="1.0" encoding="UTF-16"?>'),
    "XML GB18030": xml(point("ü"), '<?xml version="1.0" encoding="GB18030"?>'),
    "XML punycode": xml(point("ü"), '<?xml version="1.0" encoding="punycode"?>'),
    "XML hex": xml(point("u"), '<?xml version="1.0" encoding="hex"?>'),
    "XML of no encoding": xml(point("ü"), '<?xml version="1.0" encoding=""?>'),
    "XML of an odd encoding": xml(point("ü"), '<?xml version="1.0" encoding="../%00"?>'),
    "XML entities": '<!DOCTYPE m [<!ENTITY a "b">]><model>&a;</model>',
    "XML laughs": '<!DOCTYPE m [<!ENTITY a "ha"><!ENTITY b "&a;&a;">]><model>&b;</model>',
    "XML of a file": '<!DOCTYPE m [<!ENTITY a SYSTEM "file:///etc/passwd">]><model>&a;</model>',
    "XML entity": xml("&b;"),
    "XML open": "<model>",
    "XML nothing": "<",
    "XML deep": "<model>" + "<a>" * 5000,
    "XML attributes": '<model version="a" version="b"/>',
    "XML large": xml(point("a", "1e308") + point("b", "-1e308")),
    "XML digits": xml(point("a", "9" * 5000)),
    "XML NaN": xml(point("a", "NaN") + point("b", "Infinity")),
    "XML charging": xml(
        point("a")
        + '<vehicle name="v" length="1e400" energyLevelCritical="1e308" energyLevelGood="-1"'
        + ' energyLevelFullyRecharged="NaN"/>'
    ),
    "XML drawing": xml(
        point("a")
        + point("b", 5000)
        + '<path name="a --- b" sourcePoint="a" destinationPoint="b" maxVelocity="1000"/>'
        + '<visualLayout scaleX="1e308" scaleY="NaN"><modelLayoutElement visualizedObjectName="a --- b">'
        + '<property name="CONN_TYPE" value="BEZIER"/><property name="CONTROL_POINTS" value="1e308,;x,y;;"/>'
        + "</modelLayoutElement></visualLayout>"
    ),
    "XML nobody": "<model><point/><path/><vehicle/><location/><locationType/><block/><visualLayout/></model>",
    "YAML tag": "plant: !!python/object/apply:os.system ['true']",
    "YAML alias": "a: &a [1]\nb: *a\n",
    "YAML laughs": "a: &a [x, x]\nb: &b [*a, *a]\nc: [*b, *b]\n",
    "YAML merge": "a: &a {b: 1}\nc: {<<: *a}\n",
    "YAML deep": "[" * 200,
    "YAML documents": "a: 1\n---\nb: 2\n",
    "YAML numbers": f"plant: p\nwidth_m: {HUGE}\nheight_m: .nan\nnodes: [{{id: a, x_m: .inf, y_m: 1e999}}]",
    "YAML long": f"plant: p\nnodes: [{{id: a, x_m: {'9' * 5000}, y_m: 0}}]",
    "YAML dates": "plant: 2030-01-01\nname: 0o17\nwidth_m: 1:30\n",
    "YAML keys": "? [a, b]\n: c\n1: 2\nnull: 3\ntrue: 4\n",
    "YAML twice": "plant: a\nplant: b\n",
    "YAML control": "plant: a\x01b",
    "YAML tab": "plant:\n\t- a\n",
    "YAML other kinds": "plant: []\nnodes: {a: 1}\nlanes: 5\nmachines: [null, 1, [1]]\nfleet: x\n",
    "CSV": "customer,product,quantity\nc,p,1\n",
    "CSV quote": 'customer,product,quantity\n"c,p,1\n',
    "CSV surrogate": "customer,product,quantity\n\ud800,p,1\n",
    "CSV separators": "sep=\n;;;;\n",
    "CSV digits": f"customer,product,quantity,due_at\nc,p,{'9' * 5000},9999-12-31T23:59:59-14:00\n",
    "CSV other digits": "customer,product,quantity\nc,p,٣\nc,p,²\n",
    "CSV product": f"product,name,lot,material,pieces,cycle_s\np,n,1,m,1,{'9' * 400}\n,,,,,\np,n,1,m,²,1\n",
}

ODD_BYTES = {
    "zeros": bytes(100),
    "binary": bytes(range(256)),
    "UTF-16 cut": b"\xff\xfe\x3c",
    "UTF-32 cut": b"\xff\xfe\x00\x00\x3c",
    "UTF-32 off": b"\xff\xfe\x00\x00" + b"\xff" * 8,
    "mark alone": b"\xef\xbb\xbf",
    "two marks": b"\xef\xbb\xbf\xef\xbb\xbf<model/>",
    "PNG": b"\x89PNG\r\n\x1a\n" + bytes(50),
    "gzip": b"\x1f\x8b\x08\x00" + bytes(20),
    "gzip cut": b"\x1f\x8b",
    "ZIP, as of XLSX": b"PK\x03\x04" + bytes(30),
    "DXF": b"0\r\nSECTION\r\n2\r\nENTITIES\r\n0\r\n",
    "DXF of nothing": b"0\nEOF\n",
    "DXF binary": b"AutoCAD Binary DXF\r\n\x1a\x00" + bytes(20),
    **{
        f"XML {encoding}": xml(point("ü"), f'<?xml version="1.0" encoding="{encoding}"?>').encode(real)
        for encoding, real in (
            ("ANSI", "cp1252"),
            ("unicode", "utf-8"),
            ("unicode", "utf-16"),
            ("GB18030", "gb18030"),
            ("GB18030", "cp1252"),
            ("UTF-8", "cp1252"),
            ("UTF-16", "utf-8"),
            ("UTF-16", "utf-16-be"),
            ("ISO-8859-1", "latin-1"),
            ("Shift_JIS", "cp850"),
            ("punycode", "utf-8"),
        )
    },
}


async def answered(house: House, text: str | None, content: bytes) -> None:
    """Have every route that takes a file look at one: nobody answers with a bug."""
    packed = base64.b64encode(content).decode()
    made = await post(house, "/api/plant-drafts", {"name": "d"})
    draft = made.json()["id"]
    tried = [
        await post(house, "/api/plant-drafts", {"name": "d", "file_base64": packed, "onto_running": onto})
        for onto in (False, True)
    ]
    if text is not None:
        tried.append(await post(house, "/api/plant-drafts", {"name": "d", "file": text}))
    for path in ("/api/orders/import", "/api/products/import"):
        for dry_run in (True, False):
            tried.append(await post(house, path, {"base64": packed, "dry_run": dry_run}))
            if text is not None:
                tried.append(await post(house, path, {"csv": text, "dry_run": dry_run}))
    tried += [await put_plan(house, draft, kind, packed) for kind in ("image/png", "image/svg+xml")]
    for answer in tried:
        assert answer.status_code < 500, answer.text
        if answer.status_code == 201:
            data = answer.json()
            address = f"/api/plant-drafts/{data['id']}"
            assert (await house.client.get(address)).status_code == 200
            assert (await house.client.get(f"{address}/file")).status_code == 200
            await house.client.delete(address)
    await house.client.delete(f"/api/plant-drafts/{draft}")


async def put_plan(house: House, draft: str, kind: str, packed: str) -> Any:
    return await house.client.put(
        f"/api/plant-drafts/{draft}/plan", json={"media_type": kind, "base64": packed}
    )


async def post(house: House, path: str, body: Any) -> Any:
    # As programs write it, with escapes: also what no text may hold.
    return await house.client.post(
        path, content=json.dumps(body), headers={"Content-Type": "application/json"}
    )


@pytest.mark.parametrize("name", ODD_TEXTS)
async def test_an_odd_text_is_read_or_refused(house: House, name: str) -> None:
    text = ODD_TEXTS[name]
    await answered(house, text, text.encode(errors="surrogatepass"))


@pytest.mark.slow
@pytest.mark.parametrize("name", ODD_BYTES)
async def test_odd_bytes_are_read_or_refused(house: House, name: str) -> None:
    await answered(house, None, ODD_BYTES[name])


@pytest.mark.slow
@pytest.mark.parametrize("name", ODD_BYTES)
async def test_odd_bytes_are_a_floor_plan_in_dxf_or_refused(house: House, name: str) -> None:
    draft = (await post(house, "/api/plant-drafts", {"name": "d"})).json()["id"]
    packed = base64.b64encode(ODD_BYTES[name]).decode()
    answer = await put_plan(house, draft, "image/vnd.dxf", packed)
    assert answer.status_code < 500, answer.text
    await house.client.delete(f"/api/plant-drafts/{draft}")


@pytest.mark.parametrize(
    "value",
    [
        '"\\ud800"',
        "1e999",
        "NaN",
        "-Infinity",
        "9" * 400,
        "[" * 9 + "]" * 9,
        "[" * 900 + "]" * 900,
        '{"\\ud800": 1}',
    ],
)
async def test_a_draft_of_odd_values_is_kept_or_refused(house: House, value: str) -> None:
    made = (await post(house, "/api/plant-drafts", {"name": "d"})).json()
    address = f"/api/plant-drafts/{made['id']}"
    head = {"Content-Type": "application/json", "If-Match": f'"{made["version"]}"'}
    for body in (
        f'{{"name": "d", "data": {{"plant": {value}, "nodes": {value}}}}}',
        f'{{"name": {value}, "data": {{}}}}',
    ):
        answer = await house.client.put(address, content=body, headers=head)
        assert answer.status_code < 500, answer.text
    await house.client.delete(address)


@settings(deadline=None, max_examples=100, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.sampled_from(
        [text.encode(errors="surrogatepass") for text in ODD_TEXTS.values()] + list(ODD_BYTES.values())
    ),
    st.lists(st.tuples(st.integers(0, 10_000), st.integers(0, 255)), max_size=4),
)
def test_a_layout_with_flipped_bytes_is_read_or_refused(content: bytes, flips: list[tuple[int, int]]) -> None:
    broken = bytearray(content or b"<")
    for at, value in flips:
        broken[at % len(broken)] = value
    with suppress(PlantError):
        assert read_layout(bytes(broken), "hall.xml").data["nodes"]
