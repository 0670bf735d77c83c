"""Chains of waiting: who waits for whom in the end."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from dray.gateway.live.projection.right_of_way.chains import NAMED, Chain, Standing, chains_of
from dray.gateway.live.views import WaitKind

DOCKED, MOVING, SILENT = Standing("docked"), Standing("moving"), Standing("silent")


def chain(ahead: tuple[str, ...], kind: WaitKind, circle: tuple[str, ...] = ()) -> Chain:
    return Chain(kind, ahead[:NAMED], ahead[-1] if ahead else "", len(ahead), circle)


def behind(atv: str) -> Standing:
    return Standing("unanswered", waits=True, waits_for=atv)


def test_nobody_waits_where_all_drive() -> None:
    assert chains_of({"a": MOVING, "b": DOCKED}) == {}


def test_a_chain_ends_at_the_one_that_waits_for_nobody() -> None:
    chains = chains_of({"a": behind("b"), "b": behind("c"), "c": DOCKED})
    assert chains == {"a": chain(("b", "c"), "docked"), "b": chain(("c",), "docked")}


def test_the_order_in_which_vehicles_are_known_changes_nothing() -> None:
    vehicles = {"a": behind("b"), "b": behind("c"), "c": behind("d"), "d": MOVING, "e": behind("b")}
    assert chains_of(dict(reversed(vehicles.items()))) == chains_of(vehicles)


def test_who_was_never_heard_is_silent() -> None:
    assert chains_of({"a": behind("b"), "b": behind("x")})["a"] == chain(("b", "x"), "silent")


def test_a_silent_one_ends_the_chain_whatever_it_has_said_before() -> None:
    assert chains_of({"a": behind("b"), "b": SILENT}) == {"a": chain(("b",), "silent")}


def test_a_circle_is_told_by_each_from_the_next_one_on() -> None:
    chains = chains_of({"c": behind("a"), "b": behind("c"), "a": behind("b")})
    circle = ("a", "b", "c")
    assert chains == {
        "a": chain(("b", "c"), "circle", circle),
        "b": chain(("c", "a"), "circle", circle),
        "c": chain(("a", "b"), "circle", circle),
    }


def test_who_waits_for_one_in_a_circle_is_not_of_it() -> None:
    chains = chains_of({"a": behind("b"), "b": behind("c"), "c": behind("b")})
    assert chains["a"] == chain(("b", "c"), "circle", ("b", "c"))
    assert "a" not in chains["b"].circle


def test_who_waits_for_itself_is_a_circle_alone() -> None:
    assert chains_of({"a": behind("a")}) == {"a": chain((), "circle", ("a",))}


def test_who_does_not_know_for_whom_it_waits_is_the_end_of_its_own_chain() -> None:
    chains = chains_of({"a": behind("b"), "b": behind("")})
    assert chains == {"a": chain(("b",), "unanswered"), "b": chain((), "unanswered")}


def test_a_queue_of_a_thousand_names_few_of_them_and_the_last() -> None:
    queue = {f"v{number}": behind(f"v{number + 1}") for number in range(1000)} | {"v1000": DOCKED}
    first = chains_of(queue)["v0"]
    assert (len(first.ahead), first.ahead[0], first.last, first.count) == (NAMED, "v1", "v1000", 1000)
    circle = chains_of(queue | {"v1000": behind("v0")})["v999"]
    assert (len(circle.ahead), circle.ahead[0], circle.last, circle.count) == (NAMED, "v1000", "v998", 1000)


NAMES = tuple("abcdefgh")


@given(st.fixed_dictionaries({name: st.sampled_from((*NAMES, "", "x", "docked")) for name in NAMES}))
def test_every_chain_leads_from_one_to_the_next_and_names_nobody_twice(said: dict[str, str]) -> None:
    vehicles = {atv: DOCKED if other == "docked" else behind(other) for atv, other in said.items()}
    chains = chains_of(vehicles)
    assert chains.keys() == {atv for atv, standing in vehicles.items() if standing.waits}
    for atv, chain in chains.items():
        names = (atv, *chain.ahead)
        assert len(set(names)) == len(names)
        assert all(said[here] == there for here, there in zip(names, chain.ahead, strict=False))
        if chain.circle:
            assert said[names[-1]] in names
            assert all(
                said[a] == b for a, b in zip(chain.circle, (*chain.circle[1:], chain.circle[0]), strict=True)
            )
        elif names[-1] in vehicles:
            assert chain.kind == vehicles[names[-1]].kind
            assert not vehicles[names[-1]].waits_for
        else:
            assert chain.kind == "silent"
