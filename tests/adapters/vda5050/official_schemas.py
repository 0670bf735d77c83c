"""The official JSON schemas of VDA 5050, where they are: in a folder `shared` beside the clone, or beside a folder above it."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema_rs

ROOT = Path(__file__).parents[3]
MISSING = "the official schemas are not there: put those of github.com/VDA5050/VDA5050 into ../shared/vda5050/schemas"

NO_JSON = frozenset({"order", "visualization", "factsheet"})
"""Of 3.0.0, as published: they have commas before brackets. Those of the main branch are mended."""


def folder() -> Path | None:
    places = (parent / "shared/vda5050/schemas" for parent in ROOT.parents)
    return next((place for place in places if place.is_dir()), None)


@cache
def validator(version: str, topic: str) -> Any:
    place = folder()
    assert place is not None, MISSING
    tag = "main" if version == "3.0" and topic in NO_JSON else f"{version}.0"
    return jsonschema_rs.validator_for(json.loads((place / tag / f"{topic}.schema").read_text()))


def objections(version: str, topic: str, said: dict[str, Any]) -> list[str]:
    """What the schema has against a message."""
    return [f"{topic}: {error}" for error in validator(version, topic).iter_errors(said)]
