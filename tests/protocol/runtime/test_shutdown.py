"""Every agent that is asked to leave says so (paper, 4.2 case 6)."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from rigs import MachineRig, Rig, StrategistRig, VehicleRig

from dray.protocol.runtime.events import NEVER_S


@pytest.mark.parametrize("make", [VehicleRig, MachineRig, StrategistRig])
def test_an_agent_that_has_left_asks_for_no_time_to_leave(make: Callable[[], Rig]) -> None:
    rig = make()
    rig.start()
    rig.leave()
    assert rig.has_left
    assert rig.agent._shutdown.latest_s == NEVER_S  # type: ignore[attr-defined]
