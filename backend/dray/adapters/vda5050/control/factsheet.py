"""Comparison of a factsheet with the plant file's vehicle type."""

from __future__ import annotations

from dray.adapters.vda5050.profile import Profile
from dray.adapters.vda5050.wire.messages import Factsheet
from dray.plant.model import VehicleType

NEAR = 0.02
"""Relative difference up to which figures count as equal."""


def differences(sheet: Factsheet, kind: VehicleType, profile: Profile) -> tuple[str, ...]:
    """The differences in words; a figure that the factsheet lacks does not count."""
    found = []
    body = sheet.physical_parameters
    if body is not None:
        rows = (
            ("max_speed_mps", kind.max_speed_mps, body.speed_max, body.maximum_speed),
            ("acceleration_mps2", kind.acceleration_mps2, body.acceleration_max, body.maximum_acceleration),
            ("length_m", kind.length_m, body.length, None),
            ("width_m", kind.width_m, body.width, None),
        )
        for name, ours, old, new in rows:
            theirs = old if old is not None else new
            if theirs and abs(theirs - ours) > NEAR * max(ours, theirs):
                found.append(f"{name} of type {kind.id} is {ours:g}, its factsheet says {theirs:g}")
    actions = (
        {action.action_type for action in sheet.protocol_features.actions}
        if sheet.protocol_features
        else set()
    )
    if actions:
        uses = (profile.pick, profile.pick_by_hand, profile.drop, profile.charge)
        wanted = dict.fromkeys(use.type for use in uses)
        found += [f"its factsheet knows no action {name}" for name in wanted if name not in actions]
    version = sheet.version or ""
    if version and not version.startswith(profile.version):
        found.append(f"it speaks {version}, its profile says {profile.version}")
    return tuple(found)
