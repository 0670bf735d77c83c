"""The patience and the reach of auctions, round after round."""

from __future__ import annotations

import pytest

from dray.protocol.contract_net.auction_rules import AuctionRules
from dray.protocol.liveness.suspicion import DEVIATIONS

RULES = AuctionRules()


def test_the_first_round_has_the_plain_values_and_so_has_the_time_before_it() -> None:
    for round_number in (0, 1):
        assert RULES.radius_in_m(round_number) == RULES.radius_m
        assert RULES.window_in_s(round_number) == RULES.window_s
        assert RULES.answer_in_s(round_number) == RULES.answer_s
        assert RULES.rest_in_s(round_number) == RULES.rest_s


def test_windows_rests_and_waits_grow_to_their_limits_and_the_radius_without_one() -> None:
    assert [RULES.radius_in_m(round_number) for round_number in (2, 3, 4)] == [50.0, 100.0, 200.0]
    assert [RULES.window_in_s(round_number) for round_number in (2, 3)] == [1.5, 2.25]
    assert RULES.window_in_s(10_000) == RULES.window_max_s
    assert RULES.answer_in_s(10_000) == RULES.answer_s * RULES.window_max_s / RULES.window_s
    assert RULES.rest_in_s(10_000) == RULES.rest_max_s


def test_on_good_links_the_rules_stay_as_they_are() -> None:
    assert RULES.on_links(0.0, 0.0) == RULES.on_links(0.02, 0.02) == RULES


@pytest.mark.parametrize(
    ("delay_s", "deviation_s", "waits_s"),
    [(1.0, 0.0, 2.2), (1.0, 0.1, 2.0 * (1.0 + DEVIATIONS * 0.1)), (60.0, 0.0, RULES.window_max_s)],
)
def test_on_slow_links_there_is_time_for_the_way_there_and_back_but_no_more_than_the_limit(
    delay_s: float, deviation_s: float, waits_s: float
) -> None:
    rules = RULES.on_links(delay_s, deviation_s)
    assert (rules.window_s, rules.answer_s) == pytest.approx((waits_s, waits_s))
    assert rules.window_in_s(100) == pytest.approx(RULES.window_max_s)
