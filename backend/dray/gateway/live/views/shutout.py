"""That an agent is shut out, as panels see it."""

from __future__ import annotations

from dray.gateway.live.views.base import View


class ShutOutView(View, kw_only=True):
    """A manager has shut the agent out: nobody hears it, whatever it says."""

    by: str
    """The name of who has decided it."""
    reason: str
    at_s: float
