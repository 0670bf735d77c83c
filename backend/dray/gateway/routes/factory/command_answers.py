"""Commands to vehicles and machines: their names, whom none reaches, and what comes back of each."""

from __future__ import annotations

from http import HTTPStatus
from typing import Annotated

import msgspec
from pydantic import Field

from dray.gateway.access.audit_log import Note
from dray.gateway.http.problems import Problem
from dray.gateway.http.responses import Json
from dray.gateway.live.projection import Projection
from dray.gateway.live.reasons import refusal_text
from dray.gateway.live.visibility import Visibility
from dray.messages import CommandAnswered, CommandRefusal

CommandName = Annotated[str | None, Field(pattern=r"^[A-Za-z0-9._:-]{1,64}$")]


class CommandAnswer(msgspec.Struct, frozen=True):
    """What a vehicle or a machine says to a command."""

    command: str
    done: bool
    """False when it refused it."""
    reason: CommandRefusal | None = None
    """Why it was refused; None when it was done, or somebody else has stood in its way."""
    detail: str = ""
    """What its sensors still report, or why nobody waits for its word."""
    text: str = ""
    """Both in English."""


def must_be_heard(projection: Projection, agent: str, title: str, consequence: str) -> None:
    """Nobody is shut out who is given a command.

    Args:
        projection: who knows it.
        agent: who is given one.
        title: of the answer, such as "The vehicle is shut out".
        consequence: what that means, and what the caller can do.

    Raises:
        Problem: 409, it is.
    """
    if agent in projection.outsiders:
        raise Problem(HTTPStatus.CONFLICT, "shut-out", title, f"nobody hears {agent}{consequence}")


def answered(answer: CommandAnswered, note: Note, visible: Visibility) -> Json:
    """What is sent to the caller, and what the audit log keeps of it."""
    note.detail["command"] = answer.command
    text = refusal_text(answer)
    if not answer.done:
        note.result, note.detail["reason"] = "refused", text
    return Json(
        CommandAnswer(
            answer.command, answer.done, answer.reason, visible.words(answer.detail), visible.words(text)
        )
    )
