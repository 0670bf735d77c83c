"""A contest of dwell points has one winner, and everybody finds it alone (`dray.messages.floor.dwell_point`)."""

from __future__ import annotations

from defaults import KEYS, PLANT
from hypothesis import given
from hypothesis import strategies as st

from dray.messages import DwellPointClaimed
from dray.protocol.runtime.events import Publish
from dray.protocol.runtime.life import Life
from dray.protocol.vehicle.dwell_points import DwellPoints, Hold

DWELL_POINT = "CH3"
FRACS = st.sampled_from([0.1, 0.2, 0.5, 0.9])


class Claimant:
    """A vehicle that has claimed `DWELL_POINT`, or stands there."""

    def __init__(self, atv: str, battery_frac: float, standing: bool) -> None:
        self.atv = atv
        self.life = Life()
        self.out = self.life.effects
        self.dwell_points = DwellPoints(atv, PLANT, "light", KEYS, self.life)
        self.rank = (not standing, battery_frac, atv)
        if standing:
            self.dwell_points.stand(DWELL_POINT, battery_frac, 0.0)
        else:
            assert self.dwell_points.seek(
                charger=True, node=PLANT.node_of(DWELL_POINT), battery_frac=battery_frac, now_s=0.0
            )

    @property
    def holds(self) -> bool:
        return self.dwell_points.dwell_point == DWELL_POINT

    def said(self) -> list[DwellPointClaimed]:
        """What it has said since the last question."""
        claims = [effect.message for effect in self.life.effects if isinstance(effect, Publish)]
        self.life.effects.clear()
        return [claim for claim in claims if isinstance(claim, DwellPointClaimed)]


CLAIMANTS = st.lists(
    st.tuples(st.sampled_from([f"ATV{n}" for n in range(1, 8)]), FRACS),
    min_size=2,
    max_size=5,
    unique_by=lambda each: each[0],
)


@given(claimants=CLAIMANTS, occupied=st.booleans(), data=st.data())
def test_whatever_the_order_of_claims_one_holds_the_dwell_point_and_it_is_the_right_one(
    claimants: list[tuple[str, float]], occupied: bool, data: st.DataObject
) -> None:
    fleet = [Claimant(atv, frac, occupied and not index) for index, (atv, frac) in enumerate(claimants)]
    under_way = [(claim, other) for each in fleet for claim in each.said() for other in fleet]
    for _ in range(1000):
        if not under_way:
            break
        claim, listener = under_way.pop(data.draw(st.integers(0, len(under_way) - 1)))
        if listener.holds:
            listener.dwell_points.on_claim(claim, 0.5)
        under_way += [(said, other) for said in listener.said() for other in fleet if other.holds]
    assert not under_way, "they never stop arguing"
    [holder] = [each for each in fleet if each.holds]
    assert holder.rank == min(each.rank for each in fleet)


@given(
    one=st.tuples(FRACS, st.booleans()),
    other=st.tuples(FRACS, st.booleans()),
)
def test_two_who_hear_each_other_agree(one: tuple[float, bool], other: tuple[float, bool]) -> None:
    first, second = Claimant("ATV1", *one), Claimant("ATV2", *other)
    [first_claim], [second_claim] = first.said(), second.said()
    verdicts = first.dwell_points.on_claim(second_claim, 0.5), second.dwell_points.on_claim(first_claim, 0.5)
    assert sorted(verdicts) == [False, True]
    assert first.holds is (first.rank < second.rank)


@given(st.lists(FRACS, max_size=10))
def test_an_occupant_is_never_driven_out_by_who_is_not_standing(rivals: list[float]) -> None:
    occupant = Claimant("ATV5", 0.9, standing=True)
    for number, frac in enumerate(rivals):
        claim = DwellPointClaimed(
            dwell_point=DWELL_POINT, atv=f"ATV{number + 6}", battery_frac=frac, standing=False
        )
        assert not occupant.dwell_points.on_claim(claim, 0.5)
    assert occupant.dwell_points.hold is Hold.STANDING
