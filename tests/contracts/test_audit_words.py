"""Whatever the audit log names, panels name in words: every action, in every language, and in the list to choose from."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from dray.gateway.access.rules import RULES

FRONTEND = Path(__file__).parents[2] / "frontend" / "src"

ACTIONS = {rule.action for rule in RULES.values()} - {""}


@pytest.mark.parametrize("language", ["en", "de", "es"])
def test_every_action_has_words(language: str) -> None:
    texts = (FRONTEND / "text" / "views" / "records" / f"{language}.ts").read_text(encoding="utf-8")
    named = set(re.findall(r'"audit\.did\.([\w.]+)": "[^"]+"', texts))
    assert ACTIONS - named == set()


def test_every_action_can_be_looked_for() -> None:
    source = (FRONTEND / "manager" / "pages" / "audit" / "filter.ts").read_text(encoding="utf-8")
    listed = re.search(r"export const ACTIONS = \[(.*?)\]", source, re.DOTALL)
    assert listed is not None
    assert ACTIONS - set(re.findall(r'"([\w.]+)"', listed[1])) == set()
