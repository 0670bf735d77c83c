"""Vehicles notice how they are linked: WLAN, the mesh, or nothing."""

from __future__ import annotations

import asyncio

from radio_floor import SOON_S, Floor, play

from dray.messages import Link
from dray_sim.faults import AccessPointDown, CoverageHole, WlanCut
from dray_sim.network.coverage import AccessPoint, Coverage
from dray_sim.network.modem import NOTICE_S
from dray_sim.network.sim_network import NO_WLAN


def test_a_modem_notices_after_a_while_that_the_wlan_is_gone_or_back() -> None:
    async def story() -> None:
        floor = Floor(0.0, 20.0)
        await asyncio.sleep(10.0)
        floor.network.begin(WlanCut("V0"))
        await asyncio.sleep(10.0)
        floor.network.end(WlanCut("V0"))
        await asyncio.sleep(10.0)
        assert floor.noticed["V0"] == [(10.0 + NOTICE_S, Link.MESH), (20.0 + NOTICE_S, Link.WLAN)]
        assert floor.noticed["V1"] == []
        assert floor.network.link_of("V0") is Link.WLAN

    play(story())


def test_until_it_has_noticed_a_vehicle_talks_into_the_void() -> None:
    async def story() -> None:
        floor = Floor(0.0, 20.0)
        floor.network.begin(WlanCut("V0"))
        floor.beat("V0")
        await asyncio.sleep(SOON_S)
        assert not floor.beats("M")
        assert floor.network.lost == {NO_WLAN: 1}

    play(story())


def test_a_flicker_of_the_wlan_is_not_noticed() -> None:
    async def story() -> None:
        floor = Floor(0.0, 20.0)
        for _ in range(5):
            floor.network.begin(WlanCut("V0"))
            await asyncio.sleep(NOTICE_S / 2)
            floor.network.end(WlanCut("V0"))
            await asyncio.sleep(NOTICE_S)
        assert floor.noticed["V0"] == []

    play(story())


def test_the_wlan_that_is_back_is_used_when_it_has_been_noticed_and_no_frame_is_sent_any_more() -> None:
    async def story() -> None:
        floor = Floor(0.0, 20.0)
        await floor.cut("V0")
        floor.network.end(WlanCut("V0"))
        floor.beat("V0")
        await asyncio.sleep(SOON_S)
        floor.beat("V0")
        await asyncio.sleep(SOON_S)
        assert [(beat.link, beat.via) for beat in floor.beats("M")] == [
            (Link.MESH, ("V1",)),
            (Link.WLAN, ()),
        ]
        assert floor.network.radio.sent == 1

    play(story())


def test_a_vehicle_that_drives_into_a_hole_notices_with_its_heartbeats() -> None:
    async def story() -> None:
        floor = Floor(0.0, 4.0)
        floor.network.begin(CoverageHole(x_m=-10.0, y_m=0.0, radius_m=5.0))
        for second in range(60):
            floor.places_m[0] = -float(second) / 2.0
            floor.beat("V0", at_s=float(second))
            await asyncio.sleep(1.0)
        # 5 m are driven in 10 s; the 10 m through the hole take 20 s.
        assert floor.noticed["V0"] == [(11.0, Link.MESH), (32.0, Link.WLAN)]
        by_mesh = [beat.at_s for beat in floor.beats("M") if beat.link is Link.MESH]
        assert by_mesh == [float(second) for second in range(11, 32)]

    play(story())


def test_a_hole_that_opens_over_a_silent_vehicle_is_noticed_too() -> None:
    async def story() -> None:
        floor = Floor(0.0, 20.0)
        floor.network.begin(CoverageHole(x_m=0.0, y_m=0.0, radius_m=5.0))
        await asyncio.sleep(SOON_S)
        assert floor.noticed["V0"] == [(NOTICE_S, Link.MESH)]
        assert floor.noticed["V1"] == []

    play(story())


def test_an_access_point_that_fails_leaves_its_vehicles_with_their_radios() -> None:
    async def story() -> None:
        coverage = Coverage([AccessPoint("AP1", 0.0, 0.0, 15.0), AccessPoint("AP2", 25.0, 0.0, 15.0)])
        floor = Floor(0.0, 20.0, coverage=coverage)
        assert floor.network.access_points == ("AP1", "AP2")
        await floor.beat_and_wait("V0")
        floor.network.begin(AccessPointDown("AP1"))
        await floor.beat_and_wait("V0")
        await floor.beat_and_wait("V0")
        assert [beat.via for beat in floor.beats("M")] == [(), ("V1",)]
        floor.network.end(AccessPointDown("AP1"))
        await asyncio.sleep(SOON_S)
        assert [link for _, link in floor.noticed["V0"]] == [Link.MESH, Link.WLAN]
        assert floor.served["V0"] == ["AP1", ""]

    play(story())


def test_the_access_point_that_a_place_is_served_by_is_the_nearest_whether_it_is_up_or_not() -> None:
    points = [AccessPoint("AP1", 0.0, 0.0, 15.0), AccessPoint("AP2", 25.0, 0.0, 15.0)]
    coverage = Coverage(points, down=["AP1"])
    assert [coverage.nearest(x_m, 0.0) for x_m in (0.0, 12.0, 13.0, 90.0)] == ["AP1", "AP1", "AP2", ""]


def test_the_coverage_can_be_replaced_at_run_time_and_faults_stay_in_it() -> None:
    async def story() -> None:
        floor = Floor(0.0, 20.0)
        floor.network.begin(CoverageHole(x_m=20.0, y_m=0.0, radius_m=1.0))
        floor.network.cover(Coverage([AccessPoint("AP1", 20.0, 0.0, 15.0)]))
        await asyncio.sleep(SOON_S)
        assert [floor.network.link_of(name) for name in ("V0", "V1", "M")] == [
            Link.MESH,
            Link.MESH,
            Link.WLAN,
        ]
        floor.network.end(CoverageHole(x_m=20.0, y_m=0.0, radius_m=1.0))
        await asyncio.sleep(SOON_S)
        assert [floor.network.link_of(name) for name in ("V0", "V1")] == [Link.MESH, Link.WLAN]

    play(story())
