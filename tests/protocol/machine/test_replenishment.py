"""When a machine asks for what, and how early."""

from __future__ import annotations

from typing import Any

import pytest

from dray.plant.working_time import WeeklySpan, WorkingHours, WorkingTime
from dray.protocol.machine.replenishment import LeadTime, order_quantity, reorder_point, runs_out_at_s


def quantity(**changes: Any) -> int:
    """An order in a state where a lot of 40 is wanted, with some of it changed."""
    state = {"level": 10, "on_order": 0, "need": 200, "point": 30, "lot": 40, "capacity": 120}
    return order_quantity(**(state | changes))


def test_the_reorder_point_covers_the_lead_time_with_a_margin_and_one_cycle() -> None:
    assert reorder_point(use_per_s=0.1, lead_time_s=100.0, per_cycle=2, ceiling=1000) == 17


def test_the_reorder_point_leaves_room_for_a_whole_lot() -> None:
    assert reorder_point(use_per_s=10.0, lead_time_s=100.0, per_cycle=2, ceiling=80) == 80


def test_the_reorder_point_is_never_below_one_cycle() -> None:
    assert reorder_point(use_per_s=0.0, lead_time_s=100.0, per_cycle=6, ceiling=80) == 6
    assert reorder_point(use_per_s=1.0, lead_time_s=100.0, per_cycle=6, ceiling=2) == 6


def test_a_lot_is_ordered_at_the_reorder_point() -> None:
    assert quantity(level=30) == 40


def test_nothing_is_ordered_above_the_reorder_point() -> None:
    assert quantity(level=31) == 0


def test_what_is_on_order_counts_as_if_it_were_there() -> None:
    assert quantity(level=0, on_order=40) == 0
    assert quantity(level=0, on_order=30) == 40


@pytest.mark.parametrize("need", [0, 9, 10])
def test_nothing_is_ordered_that_no_goal_needs(need: int) -> None:
    assert quantity(level=10, need=need) == 0


def test_a_need_of_one_piece_more_is_ordered_as_a_whole_lot() -> None:
    assert quantity(level=10, need=11) == 40


def test_no_more_is_ordered_than_the_buffer_holds() -> None:
    assert quantity(level=10, on_order=90, point=110, capacity=120) == 20
    assert quantity(level=10, on_order=120, point=200, capacity=120) == 0


def test_material_runs_out_when_all_that_is_expected_is_used_up() -> None:
    always = WorkingTime(None)
    assert runs_out_at_s(1000.0, 50, 0.5, always) == 1100.0
    assert runs_out_at_s(1000.0, 0, 0.5, always) == 1000.0


def test_material_runs_out_in_working_time() -> None:
    mornings = WorkingTime(WorkingHours(shifts=(WeeklySpan("06:00", "12:00"),)))
    assert runs_out_at_s(0.0, 50, 0.5, mornings) == 6 * 3600.0 + 100.0
    assert runs_out_at_s(0.0, 0, 0.5, mornings) == 6 * 3600.0


def test_the_lead_time_follows_what_is_measured() -> None:
    lead = LeadTime(100.0)
    lead.note(200.0)
    assert 100.0 < lead.mean_s < 200.0
    for _ in range(100):
        lead.note(200.0)
    assert lead.mean_s == pytest.approx(200.0)


def test_one_late_delivery_moves_the_lead_time_by_a_part_only() -> None:
    lead = LeadTime(100.0)
    lead.note(1100.0)
    assert lead.mean_s <= 400.0
