"""A contest of berths has one winner, and everybody finds it alone (`dray.messages.berth`)."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st
from kit import KEYS, PLANT

from dray.messages import BerthClaimed
from dray.protocol.runtime.events import Effect, Publish
from dray.protocol.vehicle.dwell_points import DwellPoints, Hold

BERTH = "CH3"
FRACS = st.sampled_from([0.1, 0.2, 0.5, 0.9])


class Claimant:
    """A vehicle that has claimed `BERTH`, or stands there."""

    def __init__(self, atv: str, battery_frac: float, standing: bool) -> None:
        self.atv = atv
        self.out: list[Effect] = []
        self.berths = DwellPoints(atv, PLANT, "light", KEYS, self.out)
        self.rank = (not standing, battery_frac, atv)
        if standing:
            self.berths.stand(BERTH, battery_frac)
        else:
            assert self.berths.seek(
                charger=True, node=PLANT.node_of(BERTH), battery_frac=battery_frac, now_s=0.0
            )

    @property
    def holds(self) -> bool:
        return self.berths.berth == BERTH

    def said(self) -> list[BerthClaimed]:
        """What it has said since the last question."""
        claims = [effect.message for effect in self.out if isinstance(effect, Publish)]
        self.out.clear()
        return [claim for claim in claims if isinstance(claim, BerthClaimed)]


CLAIMANTS = st.lists(
    st.tuples(st.sampled_from([f"ATV{n}" for n in range(1, 8)]), FRACS),
    min_size=2,
    max_size=5,
    unique_by=lambda each: each[0],
)


@given(claimants=CLAIMANTS, occupied=st.booleans(), data=st.data())
def test_whatever_the_order_of_claims_one_holds_the_berth_and_it_is_the_right_one(
    claimants: list[tuple[str, float]], occupied: bool, data: st.DataObject
) -> None:
    fleet = [Claimant(atv, frac, occupied and not index) for index, (atv, frac) in enumerate(claimants)]
    under_way = [(claim, other) for each in fleet for claim in each.said() for other in fleet]
    for _ in range(1000):
        if not under_way:
            break
        claim, listener = under_way.pop(data.draw(st.integers(0, len(under_way) - 1)))
        if listener.holds:
            listener.berths.on_claim(claim, 0.5)
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
    verdicts = first.berths.on_claim(second_claim, 0.5), second.berths.on_claim(first_claim, 0.5)
    assert sorted(verdicts) == [False, True]
    assert first.holds is (first.rank < second.rank)


@given(st.lists(FRACS, max_size=10))
def test_an_occupant_is_never_driven_out_by_who_is_not_standing(rivals: list[float]) -> None:
    occupant = Claimant("ATV5", 0.9, standing=True)
    for number, frac in enumerate(rivals):
        claim = BerthClaimed(berth=BERTH, atv=f"ATV{number + 6}", battery_frac=frac, standing=False)
        assert not occupant.berths.on_claim(claim, 0.5)
    assert occupant.berths.hold is Hold.STANDING
