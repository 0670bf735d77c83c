"""After a restart the gateway recalls the news from the facts on disk."""

from __future__ import annotations

import pytest
from gateway_kit import gateway
from heartbeats import events
from wall_clock import NOW_S, Wall

from dray.messages import Event, Link, Reason, Role
from dray.messages.fact import (
    CarrierChanged,
    ContractEnded,
    GoalLost,
    HelpAsked,
    LinkChanged,
    TookOver,
)

pytestmark = pytest.mark.anyio

TOOK_OVER = TookOver(task="M8-3", epoch=2, primary="ATV3", silent_s=3.6, reason=Reason.SILENT)
CHANGED = CarrierChanged(
    task="M8-3", epoch=2, replaced="ATV3", carrier="ATV1", reason=Reason.SILENT, silent_s=3.9
)


def told() -> list[Event]:
    return [
        *events("ATV1", TOOK_OVER, at_s=100.0),
        *events("M8", CHANGED, at_s=101.0),
        *events("ATV5", LinkChanged(link=Link.MESH), at_s=102.0),
        *events("strategist", GoalLost(goal="G1", machine="M2", arrived=4, successor="G2"), at_s=103.0),
    ]


async def test_the_news_is_the_same_after_a_restart(url: str) -> None:
    async with gateway(url) as house:
        await house.say(told())
        before = house.projection.news.views()
    assert [news.kind for news in before] == ["took_over", "link_lost", "goal_lost"]
    async with gateway(url) as house:
        assert house.projection.news.views() == before


async def test_a_takeover_that_was_refused_is_recalled_as_refused(url: str) -> None:
    ended = ContractEnded(task="M8-3", epoch=2, role=Role.PRIMARY, reason=Reason.RELEASED)
    async with gateway(url) as house:
        await house.say(events("ATV1", TOOK_OVER, ended))
    async with gateway(url) as house:
        (news,) = house.projection.news.views()
    assert (news.kind, news.reason, news.confirmed) == ("takeover_refused", "released", True)


async def test_moments_stay_what_they_were_on_the_wall_though_the_plants_clock_begins_anew(url: str) -> None:
    async with gateway(url) as house:
        await house.say(events("ATV5", HelpAsked(task="M8-3", reason="load shifted", until_s=150.0)))
    # The test's plant clock is 0 at NOW_S in either life, but ten times as fast in the second.
    async with gateway(url, speed=10.0, wall=Wall(NOW_S + 500.0)) as house:
        (news,) = house.projection.news.views()
    assert news.at_s == NOW_S + 101.0
    # Help is waited for in factory seconds: 49 of them, which pass in 4.9 s now.
    assert news.until_at_s == pytest.approx(NOW_S + 101.0 + 4.9)


async def test_what_is_told_again_after_a_restart_is_no_news(url: str) -> None:
    async with gateway(url) as house:
        await house.say(told())
    async with gateway(url) as house:
        house.projection.discard_changes()
        await house.say(told())
        assert house.projection.news.take_changed() == ()
