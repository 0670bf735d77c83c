"""Duty: people logged in at a panel go on duty, and their agents are asked for help.

The agent runs beside the gateway (`OperatorHost`), with the tablet as its body. A tablet that polls regularly
counts as present. A person's data is held only in memory and only for the duty; decisions are in the audit
log. On the bus a person has a code. It is the same on all tablets and gateways of one day, so nobody is
counted twice.
"""

from __future__ import annotations

import asyncio
from base64 import b32encode
from collections.abc import Callable
from http import HTTPStatus
from typing import Any, Protocol

from msgspec.structs import replace

from dray.adapters.security.signing import SigningKey
from dray.body import CallPart, CallReplied, DutyChanged, DutyState, Instruction, Report, ShowCalls, ShownCall
from dray.gateway.access.principal import Principal
from dray.gateway.http.problems import Problem
from dray.messages import OPERATOR_PREFIX, CallAnswer, ProblemKind
from dray.ports import Body

AWAY_S = 15.0
"""Wall seconds without a poll after which a tablet is away; a panel polls every 3 s."""

CODE_CHARS = 8

DAY_S = 86_400.0

CONFIRMED_S = 8.0
"""Wall seconds to wait for the caller's confirmation."""

LOOK_S = 0.1


class Employed(Protocol):
    """A running agent of an operator."""

    @property
    def ended(self) -> bool:
        """Whether it has left, or another gateway runs a later incarnation."""
        ...

    def leave(self) -> None:
        """Ask it to leave. Twice is harmless."""
        ...


class OperatorHost(Protocol):
    """Runs operators' agents."""

    def employ(self, operator: str, body: Body) -> Employed:
        """Start the agent of a person who goes on duty."""
        ...


class Tablet:
    """A person at a panel, as the body of the operator's agent. Implements `dray.ports.Body`."""

    def __init__(self, state: DutyState, seen_s: float) -> None:
        self.state, self.seen_s = state, seen_s
        self.calls: tuple[ShownCall, ...] = ()
        self.employed: Employed | None = None
        self._report: Callable[[Report], None] | None = None

    def change(self, state: DutyState) -> None:
        """Report a changed state of the person or tablet."""
        if state != self.state:
            self.state = state
            self._say(DutyChanged(state))

    def reply(self, call: str, answer: CallAnswer, wait_s: float | None) -> None:
        """Report the person's answer to a call."""
        self._say(CallReplied(call=call, answer=answer, wait_s=wait_s))

    def instruct(self, instruction: Instruction) -> None:
        """See `dray.ports.Body`."""
        if isinstance(instruction, ShowCalls):
            self.calls = instruction.calls

    def sense(self) -> DutyState:
        """See `dray.ports.Body`."""
        return self.state

    def attach(self, report: Callable[[Report], None]) -> None:
        """See `dray.ports.Body`."""
        self._report = report

    def _say(self, report: Report) -> None:
        if self._report is not None and self.employed is not None and not self.employed.ended:
            self._report(report)


class DutyRota:
    """The people on duty at this gateway.

    Args:
        host: runs the agents; None where nobody can be on duty.
        authority: makes the codes, so that nobody can guess them.
        names: whether others see names, not only codes.
        wall_s: the wall clock.
    """

    def __init__(
        self, host: OperatorHost | None, authority: SigningKey, *, names: bool, wall_s: Callable[[], float]
    ) -> None:
        self._host, self._authority, self._names, self.wall_s = host, authority, names, wall_s
        self._tablets: dict[str, tuple[str, Tablet]] = {}
        """Per person, the code and the tablet."""
        self._said_off: set[str] = set()
        """People who went off duty here: another tab of theirs does not put them back on duty by itself."""

    def has_said_off(self, by: Principal) -> bool:
        """Whether this person has gone off duty here and not come back."""
        return by.id in self._said_off

    def code_of(self, person: str) -> str:
        """A person's code on the bus today."""
        code = self._authority.code(f"duty {int(self.wall_s() // DAY_S)} {person}")
        return OPERATOR_PREFIX + b32encode(code).decode()[:CODE_CHARS].lower()

    def tablet(self, by: Principal) -> tuple[str, Tablet] | None:
        """The code and tablet of a person on duty here; None if off duty."""
        known = self._tablets.get(by.id)
        if known is None or known[1].employed is None or known[1].employed.ended:
            self._tablets.pop(by.id, None)
            return None
        return known

    def look(self, by: Principal) -> tuple[str, Tablet] | None:
        """Like `tablet`, and note that the tablet is present now."""
        known = self.tablet(by)
        if known is not None:
            known[1].seen_s = self.wall_s()
            # A new login may have other areas.
            known[1].change(replace(known[1].state, there=True, **_where(by)))
        return known

    def go_on(
        self,
        by: Principal,
        *,
        on_break: bool = False,
        busy_until_s: float | None = None,
        helps_with: tuple[ProblemKind, ...] = (),
    ) -> None:
        """Put a person on duty, or change their state.

        Args:
            by: the person, with the areas and the station of the login.
            on_break: whether the person must not be asked.
            busy_until_s: end of the time for which the person is busy (plant clock).
            helps_with: kinds of problems; empty for all.

        Raises:
            Problem: 409, keys and the administrator cannot be on duty; 503, no agents run here.
        """
        if by.kind != "person":
            raise Problem(
                HTTPStatus.CONFLICT, "no-person", "Not a person", "log in as a person to go on duty"
            )
        if self._host is None:
            raise Problem(
                HTTPStatus.SERVICE_UNAVAILABLE,
                "no-duty-here",
                "Nobody can be on duty here",
                "this gateway runs no agents of operators",
            )
        state = DutyState(
            on_break=on_break,
            busy_until_s=busy_until_s,
            **_where(by),
            helps_with=helps_with,
            label=by.name if self._names else "",
        )
        self._said_off.discard(by.id)
        known = self.tablet(by)
        if known is not None:
            known[1].seen_s = self.wall_s()
            known[1].change(state)
            return
        code, tablet = self.code_of(by.id), Tablet(state, self.wall_s())
        tablet.employed = self._host.employ(code, tablet)
        self._tablets[by.id] = code, tablet

    def go_off(self, by: Principal) -> None:
        """Take a person off duty; harmless when done twice."""
        known = self._tablets.pop(by.id, None)
        if by.kind == "person":
            self._said_off.add(by.id)
        if known is not None and known[1].employed is not None:
            known[1].employed.leave()

    async def answer(
        self, by: Principal, call: str, answer: CallAnswer, wait_s: float | None, *, is_open: bool
    ) -> bool:
        """Answer a call for a person.

        Args:
            by: the person.
            call: its id.
            answer: the answer.
            wait_s: with TAKE, plant seconds until the help is done.
            is_open: whether the person sees the call and nobody has taken it; then a person who was not asked
                may take it too.

        Returns:
            Whether the caller expects this person now.

        Raises:
            Problem: 409, the person is not on duty or expected elsewhere, or the call is over or taken by
                another.
        """
        known = self.look(by)
        if known is None:
            raise Problem(
                HTTPStatus.CONFLICT, "not-on-duty", "Not on duty", "PUT /api/duty with state on first"
            )
        tablet = known[1]
        is_shown = any(shown.call.call == call for shown in tablet.calls)
        if not is_shown and not (is_open and answer is CallAnswer.TAKE):
            raise Problem(
                HTTPStatus.CONFLICT,
                "call-over",
                "Nobody is asked any more",
                f"{call} is over, or somebody else has taken it",
            )
        if answer is CallAnswer.TAKE:
            _only_one(tablet, call)
        tablet.reply(call, answer, wait_s)
        if answer is not CallAnswer.TAKE:
            return False
        for _ in range(round(CONFIRMED_S / LOOK_S)):
            await asyncio.sleep(LOOK_S)
            part = next((shown.part for shown in tablet.calls if shown.call.call == call), None)
            if part is CallPart.TAKEN:
                return True
            if part is None and is_shown:
                return False
            # A person who takes two at once has taken the first.
            _only_one(tablet, call)
            is_shown = part is not None
        return False

    async def run(self) -> None:
        """Look for absent tablets until cancelled."""
        while True:
            await asyncio.sleep(AWAY_S / 3)
            self.look_away()

    def look_away(self) -> None:
        """Mark tablets as away that have not polled for `AWAY_S`."""
        now_s = self.wall_s()
        for _, tablet in self._tablets.values():
            if now_s - tablet.seen_s > AWAY_S:
                tablet.change(replace(tablet.state, there=False))


def _only_one(tablet: Tablet, call: str) -> None:
    """Let a person take only one call at a time.

    Raises:
        Problem: 409, another caller expects this person.
    """
    for shown in tablet.calls:
        if shown.call.call != call and shown.part in {CallPart.TAKING, CallPart.TAKEN}:
            raise Problem(
                HTTPStatus.CONFLICT,
                "expected-elsewhere",
                "Expected elsewhere",
                f"{shown.call.caller} expects you: answer {shown.call.call} with decline or cannot first, then take {call}",
            )


def _where(by: Principal) -> dict[str, Any]:
    """The part of the plant for which a person is on duty, by the login."""
    return {
        "areas": () if by.areas is None else tuple(sorted(by.areas)),
        "everywhere": by.areas is None,
        "station": by.station,
    }
