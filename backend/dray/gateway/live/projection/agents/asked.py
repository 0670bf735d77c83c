"""Agents' requests to people and people's orders to agents, as panels see them."""

from __future__ import annotations

from typing import Any, cast

from dray.gateway.live.views import BodyWaitView, HelpView, OutOfServiceView, ProblemView
from dray.messages import BodyWait, HelpWanted, OutOfService, Problem
from dray.store.history.clocks import ToWall


def out_view(out: OutOfService, to_wall_s: ToWall) -> OutOfServiceView:
    """An agent's state out of service; `to_wall_s` converts plant clock to wall clock."""
    return OutOfServiceView(
        by=out.by,
        since_at_s=to_wall_s(out.since_s),
        reason=out.reason,
        back_at_s=None if out.back_s is None else to_wall_s(out.back_s),
        after_work=out.after_work,
    )


def help_view(wanted: HelpWanted, to_wall_s: ToWall) -> HelpView:
    """An agent's call for help: how long its work waits for a person."""
    return HelpView(until_at_s=to_wall_s(wanted.until_s), promised_by=wanted.promised_by)


def wait_view(wait: BodyWait, to_wall_s: ToWall) -> BodyWaitView:
    """What an agent's body waits for."""
    return BodyWaitView(what=wait.what, until=wait.until, since_at_s=to_wall_s(wait.since_s))


def problem_view(problem: Problem) -> ProblemView:
    """The details of an agent's problem."""
    return ProblemView(
        kind=cast(Any, str(problem.kind)),
        passes=problem.passes,
        needs_person=problem.needs_person,
        load_movable=problem.load_movable,
    )
