"""Compressed answers: for whoever takes them, the same content, and what is small stays as it is."""

from __future__ import annotations

import gzip
from pathlib import Path

import pytest
from gateway_kit import House

from dray.gateway.http.compression import PACKET_BYTES

PLAIN = {"Accept-Encoding": "identity"}
GZIP = {"Accept-Encoding": "br, gzip;q=0.8"}

SCRIPT = "const answer = 42;\n" * 100

pytestmark = pytest.mark.anyio


async def test_who_takes_gzip_is_answered_the_same_in_fewer_bytes(house: House) -> None:
    plain = await house.client.get("/api/plant", headers=PLAIN)
    small = await house.client.get("/api/plant", headers=GZIP)
    assert "content-encoding" not in plain.headers
    assert small.headers["content-encoding"] == "gzip"
    assert small.json() == plain.json()
    assert int(small.headers["content-length"]) < len(plain.content) / 3
    assert "accept-encoding" in small.headers["vary"].lower()


async def test_a_compressed_answer_has_a_weak_tag_and_is_not_sent_again(house: House) -> None:
    plain = await house.client.get("/api/plant", headers=PLAIN)
    small = await house.client.get("/api/plant", headers=GZIP)
    assert small.headers["etag"] == f"W/{plain.headers['etag']}"
    for tag in (small.headers["etag"], plain.headers["etag"]):
        again = await house.client.get("/api/plant", headers=GZIP | {"If-None-Match": tag})
        assert (again.status_code, again.content) == (304, b"")


async def test_what_fits_into_a_packet_is_sent_as_it_is(house: House) -> None:
    answer = await house.client.get("/api/orders", headers=GZIP)
    assert len(answer.content) < PACKET_BYTES
    assert "content-encoding" not in answer.headers


@pytest.fixture
def built(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A script as the build leaves it, and a picture that gzip makes no smaller."""
    assets = tmp_path / "assets"
    assets.mkdir()
    (assets / "main.js").write_text(SCRIPT)
    (assets / "main.js.gz").write_bytes(gzip.compress(SCRIPT.encode()))
    (assets / "font.woff2").write_bytes(b"\0" * 2000)
    monkeypatch.setattr("dray.gateway.app.STATIC", tmp_path)
    return assets


@pytest.mark.parametrize(
    ("accepted", "encoding"),
    [
        ("gzip, deflate, br", "gzip"),
        ("gzip;q=1.0", "gzip"),
        ("br, GZIP", "gzip"),
        ("gzip;q=0", None),
        ("gzip; q=0.000", None),
        ("identity", None),
        ("x-gzip", None),
    ],
)
async def test_a_built_file_comes_as_the_build_has_compressed_it(
    built: Path, house: House, accepted: str, encoding: str | None
) -> None:
    answer = await house.client.get("/static/assets/main.js", headers={"Accept-Encoding": accepted})
    assert answer.headers.get("content-encoding") == encoding
    assert answer.text == SCRIPT
    assert answer.headers["content-type"].startswith("text/javascript")
    assert answer.headers["cache-control"].endswith("immutable")
    assert answer.headers["vary"] == "Accept-Encoding"
    if encoding:
        assert int(answer.headers["content-length"]) == (built / "main.js.gz").stat().st_size


async def test_a_font_is_not_compressed_again(built: Path, house: House) -> None:
    answer = await house.client.get("/static/assets/font.woff2", headers=GZIP)
    assert "content-encoding" not in answer.headers
    assert len(answer.content) == 2000
