"""The books of right of way, as a vehicle in a rig hears them."""

from __future__ import annotations

from effects import sent
from msgspec.structs import replace
from rigs import PLANT, VehicleRig

from dray.messages import HoldsAsked, PlaceConfirmed, PlaceGranted, PlaceWished
from dray.messages.floor.traffic import PlaceBooking
from dray.protocol.runtime.events import Effect
from dray.protocol.traffic.traffic_map import TrafficMap

TRAFFIC = TrafficMap(PLANT)


def answer(rig: VehicleRig, removal: int = 0, *, grants: bool = True) -> list[Effect]:
    """The book of its newest wish grants all that it wants, or nothing."""
    district = _newest(rig).district
    keeper, copy = TRAFFIC.places.keepers_of[district][:2]
    rig.on_message(copy, HoldsAsked(district=district, epoch=0))
    wish = _newest(rig)
    places = (*wish.holds, *(place for group in wish.groups for place in group)) if grants else ()
    number = max(wish.seen, 0) + 1
    lines = tuple(PlaceBooking(place=place, number=number) for place in places)
    signed = tuple(replace(line, mark=wish.mark) for line in lines)
    rig.on_message(copy, PlaceConfirmed(district=wish.district, epoch=0, grants=signed))
    return rig.on_message(
        keeper,
        PlaceGranted(
            district=wish.district,
            epoch=0,
            life=wish.life,
            upto=wish.seq,
            grants=lines,
            removal=removal,
        ),
    )


def _newest(rig: VehicleRig) -> PlaceWished:
    return [said for said in sent(rig.all, PlaceWished) if said.holds or said.groups][-1]
