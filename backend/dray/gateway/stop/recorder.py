"""The recorder: shows and logs stops of the stop path. Runs on the gateway's loop, after the fact."""

from __future__ import annotations

from typing import Any

from dray.gateway.access.audit_log import AuditLog, Line
from dray.gateway.factory.commands import Commands
from dray.gateway.live.reasons import refusal_text
from dray.gateway.stop.sender import Stop
from dray.messages import CommandAnswered

ACTION = "vehicle.command"
"""Name of commands in the audit log, for both ways (`access.rules`)."""


class StopRecorder:
    """Shows stops on panels, and logs each in the audit log.

    A stop sent both ways has one line, for the way heard first.

    Args:
        commands: knows all commands by name.
        audit_log: writes the audit log.
    """

    def __init__(self, commands: Commands, audit_log: AuditLog) -> None:
        self._commands, self._audit_log = commands, audit_log

    def sent(self, stop: Stop) -> None:
        """Show a stop that has gone out."""
        self._commands.sent_beside(stop.atv, stop.said, stop.by)

    def ended(self, stop: Stop, answer: CommandAnswered | None) -> None:
        """Show and log the outcome; None when the vehicle has not answered in time."""
        self._commands.answered_beside(stop.atv, stop.name, answer)
        if self._commands.went_beside(stop.name):
            self._write(stop, answer)

    def _write(self, stop: Stop, answer: CommandAnswered | None) -> None:
        detail: dict[str, Any] = {"kind": stop.said.kind.value, "command": stop.name, "way": "stop"}
        if stop.by.over:
            detail["session_over"] = stop.by.over.value
        if answer is None:
            detail["status"] = 504
        elif not answer.done:
            detail["reason"] = refusal_text(answer)
        self._audit_log.write_later(
            Line(
                who=stop.by,
                address=stop.address,
                action=ACTION,
                target=stop.atv,
                result="failed" if answer is None else "done" if answer.done else "refused",
                detail=detail,
                at_s=stop.at_s,
            )
        )
