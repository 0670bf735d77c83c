"""Languages of the customer's page: complete, chosen as the reader wishes, and with their own dates and numbers."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any
from zoneinfo import ZoneInfo

import msgspec
import pytest
from wall_clock import NOW_S

from dray.gateway.access.login.texts import TEXTS as LOGIN_TEXTS
from dray.gateway.http.language import LANGUAGES, choose
from dray.gateway.tracking.eta import Range
from dray.gateway.tracking.facts import NoPage
from dray.gateway.tracking.reasons import Reason
from dray.gateway.tracking.texts import TEXTS
from dray.gateway.tracking.texts.clock import Clock, zone_named
from dray.gateway.tracking.track import StageName

UTC = ZoneInfo("UTC")
HOUR_S, DAY_S = 3600.0, 86_400.0


def flat(texts: Any) -> dict[str, str]:
    """All texts by their place."""
    found: dict[str, str] = {}
    for name, value in msgspec.to_builtins(texts).items():
        if isinstance(value, dict):
            found |= {f"{name}.{key}": text for key, text in value.items() if isinstance(text, str)}
        elif isinstance(value, str):
            found[name] = value
    return found


def test_every_language_that_is_offered_has_its_texts() -> None:
    assert TEXTS.keys() == LOGIN_TEXTS.keys() == LANGUAGES.keys()


@pytest.mark.parametrize("language", TEXTS)
def test_every_language_says_everything_and_fills_in_the_same(language: str) -> None:
    english, other = flat(TEXTS["en"]), flat(TEXTS[language])
    assert other.keys() == english.keys()
    for place, text in other.items():
        assert text.strip()
        if not place.startswith("calendar."):
            assert set(re.findall(r"\{\w+\}", text)) == set(re.findall(r"\{\w+\}", english[place])), place


@pytest.mark.parametrize("language", TEXTS)
def test_every_language_has_a_word_for_all_that_can_happen(language: str) -> None:
    texts = TEXTS[language]
    assert set(texts.why) == set(Reason)
    assert set(texts.stages) == set(StageName)
    assert set(texts.gone_title) == set(texts.gone_text) == set(texts.gone_help) == set(NoPage)
    assert (len(texts.calendar.weekdays), len(texts.calendar.months)) == (7, 12)


@pytest.mark.parametrize("language", TEXTS)
def test_a_link_without_a_page_is_told_of_in_words_that_hold_for_orders_and_transports(language: str) -> None:
    texts = TEXTS[language]
    said = " ".join([*texts.gone_title.values(), *texts.gone_text.values(), *texts.gone_help.values()])
    assert not re.search(r"\border|auftr[aä]g|pedido|transport", said, re.IGNORECASE)


@pytest.mark.parametrize(
    ("chosen", "remembered", "accepted", "language"),
    [
        ("", "", "", "en"),
        ("", "", "fr-FR,fr;q=0.9", "en"),
        ("", "", "de-AT,en;q=0.5", "de"),
        ("", "", "en;q=0.5, es-MX;q=0.8", "es"),
        ("", "", "de;q=0, es;q=0.1", "es"),
        ("", "es", "de", "es"),
        ("de", "es", "en", "de"),
        ("xx", "yy", "es", "es"),
        ("", "", "de;q=many,*;q=0.1,;;,q=1", "en"),
        ("", "", "x," * 10_000 + "de", "en"),
    ],
)
def test_the_reader_decides_on_the_language(
    chosen: str, remembered: str, accepted: str, language: str
) -> None:
    assert choose(chosen, remembered, accepted) == language


@pytest.mark.parametrize(
    ("language", "days", "written"),
    [
        ("en", 0, "Today, 17:46"),
        ("en", -1, "Yesterday, 17:46"),
        ("en", 3, "Wed 20 Mar, 17:46"),
        ("en", 300, "11 Jan 2031, 17:46"),
        ("de", 1, "Morgen, 17:46"),
        ("de", 3, "Mi, 20. März, 17:46"),
        ("es", 3, "Mié, 20 mar, 17:46"),
    ],
)
def test_days_are_written_as_people_do(language: str, days: int, written: str) -> None:
    assert Clock(TEXTS[language], UTC, NOW_S).moment(NOW_S + days * DAY_S) == written


def test_a_range_names_a_day_once_and_its_beginning_only_while_it_lies_ahead() -> None:
    clock = Clock(TEXTS["en"], UTC, NOW_S)
    assert clock.range(Range(NOW_S + 60, NOW_S + HOUR_S), NOW_S) == "Today, 17:47 – 18:46"
    assert clock.range(Range(NOW_S - 60, NOW_S + HOUR_S), NOW_S) == "Today, by about 18:46"
    over_night = clock.range(Range(NOW_S + HOUR_S, NOW_S + 8 * HOUR_S), NOW_S)
    assert over_night == "Today, 18:46 – tomorrow, 01:46"


def test_today_is_the_readers_day() -> None:
    clock = Clock(TEXTS["en"], ZoneInfo("Asia/Tokyo"), NOW_S)
    assert (clock.moment(NOW_S), clock.zone) == ("Today, 02:46", "Asia/Tokyo")
    assert clock.full(NOW_S) == "18 Mar 2030, 02:46"


@pytest.mark.parametrize(
    ("language", "value", "written"),
    [
        ("en", 999, "999"),
        ("en", 12_500, "12,500"),
        ("de", 1_250, "1.250"),
        ("es", 1_250, "1250"),
        ("es", 10_000, "10.000"),
    ],
)
def test_large_numbers_are_grouped_where_the_language_does_it(
    language: str, value: int, written: str
) -> None:
    assert Clock(TEXTS[language], UTC, NOW_S).number(value) == written


@pytest.mark.parametrize(
    "name", ["", "Nowhere/Land", "../../etc/passwd", "/etc/passwd", "a" * 500, "Europe", "\x00", "é"]
)
def test_a_time_zone_that_is_none_is_ignored(name: str) -> None:
    assert zone_named(name) is None


PANEL_TEXTS = Path(__file__).parents[3] / "frontend/src/text/manager"


@pytest.mark.parametrize("language", TEXTS)
def test_the_panels_and_the_customers_page_call_the_same_state_by_one_word(language: str) -> None:
    panel = (PANEL_TEXTS / language / "orders.ts").read_text(encoding="utf-8")
    for stage in (StageName.PLANNED, StageName.IN_PRODUCTION, StageName.DELIVERED):
        said = re.search(rf'"order\.{stage.value}": "(.+)"', panel)
        assert said is not None
        assert said[1].casefold() == TEXTS[language].stages[stage.value].casefold()
