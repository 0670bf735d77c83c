"""The tables of right of way, as a vehicle in a rig hears them."""

from __future__ import annotations

from effects import sent
from msgspec.structs import replace
from rigs import PLANT, VehicleRig

from dray.messages import HoldsAsked, PlaceConfirmed, PlaceGranted, PlaceRequested
from dray.messages.floor.traffic import PlaceReservation
from dray.protocol.runtime.events import Effect
from dray.protocol.traffic.traffic_map import TrafficMap

TRAFFIC = TrafficMap(PLANT)


def answer(rig: VehicleRig, removal: int = 0, *, grants: bool = True) -> list[Effect]:
    """The table of its newest request grants all that it wants, or nothing."""
    district = _newest(rig).district
    replica, copy = TRAFFIC.places.replicas_of[district][:2]
    rig.on_message(copy, HoldsAsked(district=district, epoch=0))
    request = _newest(rig)
    places = (*request.holds, *(place for group in request.groups for place in group)) if grants else ()
    number = max(request.seen, request.renews) + 1
    lines = tuple(PlaceReservation(place=place, number=number) for place in places)
    signed = tuple(replace(line, mark=request.mark) for line in lines)
    rig.on_message(copy, PlaceConfirmed(district=request.district, epoch=0, grants=signed))
    return rig.on_message(
        replica,
        PlaceGranted(
            district=request.district,
            epoch=0,
            life=request.life,
            upto=request.seq,
            grants=lines,
            removal=removal,
        ),
    )


def _newest(rig: VehicleRig) -> PlaceRequested:
    return [said for said in sent(rig.all, PlaceRequested) if said.holds or said.groups][-1]
