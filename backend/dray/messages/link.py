"""The way by which a vehicle is heard, and since when it has not been the WLAN."""

from __future__ import annotations

from enum import StrEnum

from dray.messages.base import Part, Seconds, Text


class Link(StrEnum):
    """The way by which an ATV's heartbeat reaches the cloud (paper, case 3)."""

    WLAN = "wlan"
    MESH = "mesh"


class LostWlan(Part, frozen=True):
    """A vehicle is left with its radio."""

    since_s: Seconds
    """When its agent knew (plant clock); of one that was started without WLAN, when it was started."""
    access_point: Text = ""
    """Over which it was on the WLAN last; empty where its modem does not know."""
