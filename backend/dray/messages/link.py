"""The link by which a vehicle is heard, and how it lost the WLAN."""

from __future__ import annotations

from enum import StrEnum

from dray.messages.base import Part, Seconds, Text


class Link(StrEnum):
    """The link by which an ATV's heartbeat reaches the cloud (paper, case 3)."""

    WLAN = "wlan"
    MESH = "mesh"


class LostWlan(Part, frozen=True):
    """A vehicle that has only its radio."""

    since_s: Seconds
    """When its agent noticed (plant clock), or when it was started, if that was without WLAN."""
    access_point: Text = ""
    """The last access point of its WLAN; empty when its modem does not know."""
