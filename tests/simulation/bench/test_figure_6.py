"""The experiments of the paper's Figure 6 on real links, between computers that are network namespaces."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
from forbidden import forbidden

from dray.errors import UnavailableError
from dray.protocol.liveness.suspicion import WORKING_INTERVAL_S, bound_s
from dray_sim.bench.network.computers import Computers
from dray_sim.bench.network.field import LEASE_S, Field
from dray_sim.bench.network.links import AGAIN_S, AIR_S, cut_wlan, switch_off
from dray_sim.scenarios.paper.figure_6 import PRIMARY, SECONDARY

LOSS_FRAC = 0.1
"""Of the primary's heartbeats, as the secondary estimates it after the cut."""

PAIR = ("one", "other")


@pytest.fixture(autouse=True)
def several_computers() -> None:
    """This computer can be several."""
    if shutil.which("ip") is None:
        pytest.skip("iproute2 is not installed; on Debian: apt-get install iproute2")
    try:
        with Computers.opened(PAIR, PAIR):
            pass
    except UnavailableError as error:
        forbidden(str(error))


def interfaces(*of: str) -> str:
    return subprocess.run(["ip", *of, "-brief", "link"], capture_output=True, text=True, check=True).stdout


@pytest.mark.campaign
def test_a_cut_link_is_gone_round_and_a_dead_vehicle_is_replaced_once(tmp_path: Path) -> None:
    with Field.opened(tmp_path) as field:
        task = field.contract()
        assert (task.primary, task.secondary, task.epoch) == (PRIMARY, SECONDARY, 1)
        cut, off = cut_wlan(field, task), switch_off(field, task)
    # The mesh was in time, and nobody was disturbed. A heartbeat that came just before the lease was over is lost,
    # and the next one is a second later.
    assert max(cut.heard_s, cut.noticed_s) <= LEASE_S + AGAIN_S + AIR_S
    assert cut.silent_s <= bound_s(WORKING_INTERVAL_S)
    assert cut.disturbed == 0
    # Then one vehicle took over, once and in time.
    assert off.took_s <= bound_s(WORKING_INTERVAL_S, LOSS_FRAC) + AIR_S
    assert (off.carrier, off.epoch, off.takeovers) == (SECONDARY, 2, 1)


class Broken(Exception):
    """What was done on the computers has failed."""


def test_computers_leave_nothing_behind_and_touch_nothing_of_this_one() -> None:
    before = interfaces()
    names = []

    def break_off() -> None:
        with Computers.opened(PAIR, PAIR) as computers:
            names.extend(computers.command(name)[3] for name in PAIR)
            for name, other in zip(names, reversed(PAIR), strict=True):
                inside = {line.split()[0].partition("@")[0] for line in interfaces("-n", name).splitlines()}
                assert inside == {"lo", "wlan0", other}
            assert interfaces() == before
            raise Broken

    with pytest.raises(Broken):
        break_off()
    assert interfaces() == before
    listed = subprocess.run(["ip", "netns", "list"], capture_output=True, text=True, check=True).stdout
    assert len(names) == len(PAIR)
    assert not any(name in listed for name in names)
