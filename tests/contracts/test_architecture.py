"""The maps of the code are true: rooms, imports and ports are those that docs/architecture.md and the protocol's README draw."""

from __future__ import annotations

import ast
import re
import tomllib
from collections import defaultdict
from collections.abc import Mapping
from functools import cache
from itertools import product
from pathlib import Path

ROOT = Path(__file__).parents[2]
PROTOCOL = ROOT / "backend" / "dray" / "protocol"
README = (PROTOCOL / "README.md").read_text(encoding="utf-8")
ARCHITECTURE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
MODULES = sorted(path for path in PROTOCOL.rglob("*.py") if path.name != "__init__.py")

IMPORT = re.compile(r"^\s*(?:from|import) (dray\.[\w.]+)", re.MULTILINE)
"""Of a whole module each: nothing is imported as a name of `dray` or `dray.protocol`. To parse all modules takes longer than a second."""

Arrows = Mapping[str, set[str]]
"""By room, those that it imports, or that arrows lead to."""


def layers_of(container: str) -> list[str]:
    """The layers of an import contract, the highest first, each as documents write it."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    (contract,) = (
        each for each in project["tool"]["importlinter"]["contracts"] if each.get("containers") == [container]
    )
    return [re.sub(r"[()]", "", layer) for layer in contract["layers"]]


def drawn_layers(text: str, first: str) -> list[str]:
    """The indented block of a document that begins with this layer; what is written beside a layer is left out."""
    lines = text.splitlines()
    start = lines.index(f"    {first}")
    block: list[str] = []
    for line in lines[start:]:
        if not line.startswith("    "):
            break
        block.append(line.strip().split("  ")[0])
    return block


def room_of(path: Path) -> str:
    return path.relative_to(PROTOCOL).with_suffix("").parts[0]


@cache
def imports() -> dict[Path, set[tuple[str, ...]]]:
    """What each module of the protocol imports of `dray`, as parts of its name."""
    return {
        path: {tuple(name.split(".")) for name in IMPORT.findall(path.read_text(encoding="utf-8"))}
        for path in MODULES
    }


def imported_rooms() -> Arrows:
    rooms: defaultdict[str, set[str]] = defaultdict(set)
    for path, names in imports().items():
        rooms[room_of(path)] |= {name[2] for name in names if name[1] == "protocol"} - {room_of(path)}
    # It draws the tables of the others; nobody imports it.
    return {room: others for room, others in rooms.items() if room != "states"}


def drawn_rooms() -> Arrows:
    """The arrows of the protocol in the diagram."""
    drawing = re.search(r"subgraph protocol \[.*?\]\n(.*?)\n\s+end\n", ARCHITECTURE, re.DOTALL)
    assert drawing is not None
    arrows: defaultdict[str, set[str]] = defaultdict(set)
    for line in re.sub(r'\["[^"]*"\]', "", drawing[1]).splitlines():
        starts, ends = (side.split(" & ") for side in line.strip().split(" --> "))
        for start, end in product(starts, ends):
            arrows[start].add(end)
    return arrows


def reached_from(room: str, arrows: Arrows) -> set[str]:
    reached: set[str] = set()
    ahead = [room]
    while ahead:
        new = arrows.get(ahead.pop(), set()) - reached
        reached |= new
        ahead += new
    return reached


def wrong_arrows(drawn: Arrows, imported: Arrows) -> list[str]:
    """Arrows that are no import, and imports that follow from no arrow."""
    invented = [f"{a} -> {b} is no import" for a in drawn for b in drawn[a] - imported.get(a, set())]
    left_out = [f"{a} -> {b} is not drawn" for a in imported for b in imported[a] - reached_from(a, drawn)]
    return sorted((*invented, *left_out))


def test_the_protocols_readme_names_every_module_once_and_nothing_else() -> None:
    named = re.findall(r"^\| `([\w/]+\.py)` \|", README, re.MULTILINE)
    assert sorted(named) == sorted(str(path.relative_to(PROTOCOL)) for path in MODULES)


def test_the_protocols_readme_says_of_every_module_what_is_kept_there() -> None:
    rows = re.findall(r"^\| `[\w/]+\.py` \| (.*?) \| .*\|$", README, re.MULTILINE)
    assert len(rows) == len(MODULES)
    assert all(rows)


def test_the_protocols_readme_draws_the_layers_of_its_import_contract() -> None:
    assert drawn_layers(README, "states") == layers_of("dray.protocol")


def test_architecture_draws_the_floors_of_the_import_contract() -> None:
    assert drawn_layers(ARCHITECTURE, "__main__") == layers_of("dray")


def test_the_arrows_of_the_protocol_are_its_imports() -> None:
    assert len(imported_rooms()) > 10
    assert wrong_arrows(drawn_rooms(), imported_rooms()) == []


def test_an_arrow_that_is_no_import_and_an_import_without_an_arrow_are_found() -> None:
    drawn, imported = {"a": {"b"}, "b": {"c"}}, {"a": {"b", "c"}, "d": {"c"}}
    assert wrong_arrows(drawn, imported) == ["b -> c is no import", "d -> c is not drawn"]


def test_the_protocol_imports_of_dray_what_architecture_says_and_nothing_else() -> None:
    said = re.search(r"From `dray`, `protocol` imports (.*?) only", ARCHITECTURE)
    assert said is not None
    imported = {name[1] for names in imports().values() for name in names} - {"protocol"}
    assert set(re.findall(r"`(\w+)`", said[1])) == imported


def test_the_ports_that_architecture_names_are_those_of_the_code() -> None:
    tree = ast.parse((ROOT / "backend" / "dray" / "ports.py").read_text(encoding="utf-8"))
    ports = {node.name for node in tree.body if isinstance(node, ast.ClassDef)}
    row = re.search(r"^\| `backend/dray/ports.py` \|.*$", ARCHITECTURE, re.MULTILINE)
    assert row is not None
    assert set(re.findall(r"`([A-Z]\w+)`", row[0])) == ports
    # The bus gives each agent a session.
    assert "in four ports" in row[0]
    assert len(ports - {"Session"}) == 4
