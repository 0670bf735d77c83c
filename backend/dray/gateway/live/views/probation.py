"""The probation of a vehicle or a machine as panels see it."""

from __future__ import annotations

from dray.gateway.live.views.base import View


class ProbationView(View, kw_only=True):
    """How far an agent on probation has come: so many transports have to be done well."""

    of: int
    done: int = 0
