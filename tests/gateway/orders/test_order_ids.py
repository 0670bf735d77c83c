from __future__ import annotations

from itertools import pairwise

from dray.gateway.orders.order_ids import Ids

BEGUN_S = 1_900_000_000.0


def _moment(name: str) -> str:
    return name.split("-")[1]


def test_a_clock_that_stands_or_goes_back_gives_no_moment_twice() -> None:
    ids = Ids("O")
    names = [ids.next(BEGUN_S) for _ in range(2_000)]
    names += [ids.next(BEGUN_S - 10.0) for _ in range(10)]
    assert all(_moment(a) < _moment(b) for a, b in pairwise(names))


def test_ids_of_a_millisecond_each_do_not_share_one() -> None:
    """Times are floats: some of a thousandth more are not in the next millisecond."""
    ids = Ids("O")
    moments = {_moment(ids.next(BEGUN_S + index / 1000)) for index in range(1_000)}
    assert len(moments) == 1_000


def test_an_id_tells_its_kind_and_sorts_by_time() -> None:
    ids = Ids("T")
    early = ids.next(BEGUN_S)
    assert early.startswith("T-1Q9GD6E00-")
    assert ids.next(BEGUN_S + 3_600.0) > early
