"""The base of all views."""

from __future__ import annotations

import msgspec


class View(msgspec.Struct, gc=False):
    """Base of everything that a panel is shown."""
