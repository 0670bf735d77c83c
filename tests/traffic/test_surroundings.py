"""What vehicles know of one another by what replicas of reservation tables tell: where they listen, whom they believe, and for how long."""

from __future__ import annotations

from dray.messages.floor.traffic import FloorReported, OnFloor
from dray.messages.keys import Keys
from dray.plant import default_plant
from dray.protocol.runtime.events import Effect, Subscribe, Unsubscribe
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.prices import SILENT_S, Prices
from dray.protocol.traffic.surroundings import AGAIN_S, COUNTS_S, Surroundings
from dray.protocol.traffic.traffic_map import TrafficMap

PLACES = TrafficMap(default_plant()).places
KEYS = Keys("plant")
DISTRICT, FAR = next(
    (one, other)
    for one in PLACES.replicas_of
    for other in PLACES.replicas_of
    if other not in PLACES.around(one)
)
REPLICA = PLACES.replicas_of[DISTRICT][0]
HERE, THERE = sorted(PLACES.places_in(DISTRICT))[:2]


def on_floor(atv: str = "B", *holds: str, silent: bool = False, route: tuple[str, ...] = ()) -> OnFloor:
    return OnFloor(
        atv=atv, holds=holds, stands=True, docked=False, silent=silent, rank=(0, 0.0, atv), route=route
    )


def told(*vehicles: OnFloor, number: int = 1, epoch: int = 3) -> FloorReported:
    return FloorReported(district=DISTRICT, epoch=epoch, number=number, vehicles=vehicles)


def heard(out: list[Effect]) -> set[str]:
    """The keys that it listens to."""
    keys: set[str] = set()
    for effect in out:
        if isinstance(effect, Subscribe):
            keys.add(effect.key)
        elif isinstance(effect, Unsubscribe):
            keys.remove(effect.key)
    return keys


def test_it_listens_to_the_district_where_it_is_and_to_those_beside_it_while_it_must_know() -> None:
    life = Life()
    surroundings = Surroundings("A", PLACES, KEYS.floor, life)
    surroundings.listen([DISTRICT], 0.0)
    assert heard(life.effects) == {KEYS.floor(near) for near in PLACES.around(DISTRICT)}
    assert KEYS.floor(FAR) not in heard(life.effects)
    surroundings.listen([DISTRICT, FAR], 1.0)
    assert heard(life.effects) == {KEYS.floor(near) for one in (DISTRICT, FAR) for near in PLACES.around(one)}
    surroundings.listen([], 2.0)
    assert heard(life.effects) == set()


def test_only_who_keeps_the_table_is_believed_and_no_word_that_was_overtaken() -> None:
    surroundings = Surroundings("A", PLACES, KEYS.floor, Life())
    assert not surroundings.on_floor("B", told(on_floor("B", HERE)), 0.0)
    assert surroundings.on_floor(REPLICA, told(on_floor("B", HERE), number=2), 0.0)
    assert not surroundings.on_floor(REPLICA, told(on_floor("B", THERE), number=1), 0.1)
    assert not surroundings.on_floor(REPLICA, told(on_floor("B", THERE), epoch=2, number=9), 0.1)
    assert surroundings.others(0.1)["B"].holds == (HERE,)


def test_an_absurd_epoch_keeps_nobody_from_being_heard_for_long() -> None:
    surroundings = Surroundings("A", PLACES, KEYS.floor, Life())
    assert surroundings.on_floor(REPLICA, told(epoch=2**53), 0.0)
    assert not surroundings.on_floor(REPLICA, told(on_floor("B", HERE)), COUNTS_S - 0.1)
    assert surroundings.on_floor(REPLICA, told(on_floor("B", HERE)), COUNTS_S)


def test_a_word_is_forgotten_and_counts_for_a_while_again_after_a_rest() -> None:
    surroundings = Surroundings("A", PLACES, KEYS.floor, Life())
    surroundings.listen([DISTRICT], 0.0)
    surroundings.on_floor(REPLICA, told(on_floor("B", HERE), on_floor("A", THERE)), 0.0)
    assert set(surroundings.others(COUNTS_S - 0.1)) == {"B"}
    assert surroundings.others(COUNTS_S) == {}
    surroundings.listen([], 20.0)
    surroundings.listen([DISTRICT], 600.0)
    assert set(surroundings.others(600.0)) == {"B"}
    assert surroundings.others(600.0 + AGAIN_S) == {}


def test_prices_count_silent_ones_and_who_comes_the_other_way() -> None:
    surroundings = Surroundings("A", PLACES, KEYS.floor, Life())
    surroundings.on_floor(
        REPLICA, told(on_floor("B", HERE, silent=True), on_floor("C", THERE, route=(THERE, HERE))), 0.0
    )
    prices = Prices(surroundings.others(1.0))
    assert prices.place_s[HERE] == SILENT_S
    assert (prices.oncoming(HERE, THERE), prices.oncoming(THERE, HERE)) == (1, 0)
    assert surroundings.silent_at(1.0) == {HERE}
