"""Commands to vehicles and machines: names, exclusions, and answers."""

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
    """The answer of a vehicle or machine to a command."""

    command: str
    done: bool
    """False if refused."""
    reason: CommandRefusal | None = None
    """Reason of a refusal; None if it was done, or something else prevented it."""
    detail: str = ""
    """What its sensors still report, or why its answer is not awaited."""
    text: str = ""
    """Reason and detail in English."""


def must_be_heard(projection: Projection, agent: str, title: str, consequence: str) -> None:
    """Refuse commands to agents that are shut out.

    Args:
        projection: knows the exclusions.
        agent: the addressee.
        title: title of the problem, such as "The vehicle is shut out".
        consequence: the consequence, and what the caller can do.

    Raises:
        Problem: 409, it is shut out.
    """
    if agent in projection.outsiders:
        raise Problem(HTTPStatus.CONFLICT, "shut-out", title, f"nobody hears {agent}{consequence}")


def answered(answer: CommandAnswered, note: Note, visible: Visibility) -> Json:
    """The answer to the caller; notes the result for the audit log."""
    note.detail["command"] = answer.command
    text = refusal_text(answer)
    if not answer.done:
        note.result, note.detail["reason"] = "refused", text
    return Json(
        CommandAnswer(
            answer.command, answer.done, answer.reason, visible.words(answer.detail), visible.words(text)
        )
    )
