"""Findings of the plant's checks reach people in their language: each code has words, with nothing to be filled in that it has not."""

from __future__ import annotations

import re
from pathlib import Path
from string import Formatter

import pytest

from dray.plant.file.reasons import TEXTS

FINDINGS = Path(__file__).parents[2] / "frontend" / "src" / "text" / "views" / "findings"

LINE = re.compile(r'^  "finding\.(\w+)": "(.*)",$', re.MULTILINE)


def words(language: str) -> dict[str, str]:
    """By code, what panels say."""
    return dict(LINE.findall((FINDINGS / f"{language}.ts").read_text(encoding="utf-8")))


def names(text: str) -> set[str]:
    """What is filled into a text."""
    return {name for _, name, _, _ in Formatter().parse(text) if name}


@pytest.mark.parametrize("language", ["en", "de", "es"])
def test_every_code_has_words_that_fill_in_what_it_tells(language: str) -> None:
    said = words(language)
    assert said.keys() == TEXTS.keys()
    # A language may leave out what is English in itself; it fills in nothing else.
    assert {code for code, text in said.items() if not names(text) <= names(TEXTS[code])} == set()


def test_the_panels_english_is_the_gateways() -> None:
    plain = {code: re.sub(r"\{(\w+):[^}]*\}", r"{\1}", text) for code, text in TEXTS.items()}
    assert words("en") == plain
