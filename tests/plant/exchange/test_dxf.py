"""Floor plans in DXF: their lines in metres, what is left out told, and what is too much or none refused."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import ezdxf
import pytest

from dray.errors import PlantError
from dray.plant.exchange import dxf
from dray.plant.exchange.dxf import read_dxf


def drawn(file: Path, draw: Callable[[Any], None], *, unit: int = 4, binary: bool = False) -> Path:
    document = ezdxf.new()
    document.header["$INSUNITS"] = unit
    draw(document)
    document.saveas(file, fmt="bin" if binary else "asc")
    return file


def hall(document: Any) -> None:
    """40 m x 20 m with its walls, a pillar, an arc and a text."""
    space = document.modelspace()
    space.add_lwpolyline([(1000, 1000), (41_000, 1000), (41_000, 21_000), (1000, 21_000)], close=True)
    pillar = document.blocks.new("PILLAR")
    pillar.add_circle((0, 0), 400)
    for x in (10_000, 20_000):
        space.add_blockref("PILLAR", (x, 10_000))
    space.add_text("Hall 3")
    document.layers.add("FURNITURE").off()
    space.add_line((0, 0), (90_000, 90_000), dxfattribs={"layer": "FURNITURE"})


@pytest.mark.parametrize("binary", [False, True])
def test_a_hall_is_drawn_in_metres_with_its_blocks_and_what_is_left_out_is_told(
    tmp_path: Path, binary: bool
) -> None:
    plan = read_dxf(drawn(tmp_path / "hall.dxf", hall, binary=binary))
    assert (plan.width_m, plan.height_m) == (40.0, 20.0)
    assert plan.notes == ("left out: TEXT, 1 times", "left out: what is on hidden layers, 1 times")
    assert 'viewBox="0 0 40000 20000"' in plan.svg
    lines = re.findall(r"M\d+ \d+l[^M\"]*", plan.svg)
    assert len(lines) == 3
    # Down the left wall, as it closes: y runs down in a picture.
    assert lines[0] == "M0 20000l40000 0 0 -20000 -40000 0 0 20000"
    # A circle is so fine that no corner is seen.
    assert all(len(line.split()) > 20 for line in lines[1:])


@pytest.mark.parametrize(
    ("unit", "side_m"), [(1, 0.0254), (2, 0.3048), (4, 0.001), (5, 0.01), (6, 1.0), (14, 0.1)]
)
def test_its_unit_is_read(tmp_path: Path, unit: int, side_m: float) -> None:
    file = drawn(tmp_path / "a.dxf", lambda it: it.modelspace().add_line((0, 0), (500, 0)), unit=unit)
    assert read_dxf(file).width_m == pytest.approx(500 * side_m)


@pytest.mark.parametrize(("length", "width_m"), [(40, 40.0), (40_000, 40.0)])
def test_without_a_unit_one_is_assumed_and_told(tmp_path: Path, length: float, width_m: float) -> None:
    file = drawn(tmp_path / "a.dxf", lambda it: it.modelspace().add_line((0, 0), (length, 0)), unit=0)
    plan = read_dxf(file)
    assert plan.width_m == width_m
    assert "it does not say its unit" in plan.notes[0]
    assert plan.notes[0].values == {"length": length}


def nested(document: Any) -> None:
    """Blocks of ten blocks of ten blocks: a file of some kilobytes with 100,000 lines."""
    document.blocks.new("B0").add_line((0, 0), (1, 1))
    for depth in range(1, 6):
        block = document.blocks.new(f"B{depth}")
        for at in range(10):
            block.add_blockref(f"B{depth - 1}", (at, depth))
    document.modelspace().add_blockref("B5", (0, 0))


def test_blocks_of_blocks_are_counted_and_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dxf, "MAX_ENTITIES", 5000)
    with pytest.raises(PlantError, match="more than 5000 entities"):
        read_dxf(drawn(tmp_path / "a.dxf", nested))


def test_a_block_that_contains_itself_is_refused(tmp_path: Path) -> None:
    def endless(document: Any) -> None:
        block = document.blocks.new("SELF")
        block.add_line((0, 0), (5, 5))
        block.add_blockref("SELF", (0, 0))
        document.modelspace().add_blockref("SELF", (0, 0))

    with pytest.raises(PlantError, match="contains itself"):
        read_dxf(drawn(tmp_path / "a.dxf", endless))


def test_more_corners_than_a_picture_may_have_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dxf, "MAX_CORNERS", 50)
    with pytest.raises(PlantError, match="corners, 50 at most: hide layers"):
        read_dxf(drawn(tmp_path / "a.dxf", hall))


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"", "no line is in its model space"),
        (b"AC1032\x00\x00", "it is DWG: save it as DXF"),
        (b"<svg/>", "no DXF that can be read"),
        (b"  0\nSECTION\n  2\nENTITIES\n  0\nLINE\n 10\nfar\n", "no line is in its model space|no DXF"),
        (b"\xff" * 1000, "no DXF that can be read"),
        (b"AutoCAD Binary DXF\r\n\x1a\x00" + b"\x07" * 50, "no DXF that can be read"),
    ],
)
def test_what_is_no_plan_is_refused_with_the_reason(tmp_path: Path, content: bytes, why: str) -> None:
    file = tmp_path / "a.dxf"
    file.write_bytes(content)
    with pytest.raises(PlantError, match=why):
        read_dxf(file)


def test_what_has_no_shape_is_left_out(tmp_path: Path) -> None:
    def odd(document: Any) -> None:
        space = document.modelspace()
        space.add_line((0, 0), (10, 0))
        space.add_line((5, 5), (5, 5))
        space.add_line((0, 0), (float("inf"), 0))

    plan = read_dxf(drawn(tmp_path / "a.dxf", odd, unit=6))
    assert plan.width_m == 10.0
    assert plan.notes == ("left out: LINE without a shape, 2 times",)


def test_a_file_that_is_too_large_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dxf, "MAX_BYTES", 100)
    with pytest.raises(PlantError, match="100 at most"):
        read_dxf(drawn(tmp_path / "a.dxf", hall))
