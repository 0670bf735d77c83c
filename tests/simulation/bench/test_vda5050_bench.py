"""What a driver of a vehicle costs is measured beside a bare MQTT client."""

from __future__ import annotations

import pytest

from dray_sim.bench import BENCHES


@pytest.mark.campaign
def test_a_driver_is_measured() -> None:
    cpu, delay = BENCHES["vda5050"](True)
    assert "bare MQTT client" in cpu.baseline_name
    assert cpu.figure > 0
    assert "0 ways failed" in delay.note
