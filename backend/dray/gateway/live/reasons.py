"""The English words for reasons, for REST and logs. Panels have their own, in their reader's language."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from dray.gateway.live.views import CauseView, FailureView, LackView, WaitCauseView, WaitKind
from dray.messages import (
    CommandAnswered,
    CommandRefusal,
    Implausible,
    MaterialWait,
    Reason,
    RemovalRefusal,
    TaskBrief,
)
from dray.messages.fact import GoalWaits
from dray.messages.people.command import PROMISE_MAX_S

REASONS: Mapping[Reason, str] = {
    Reason.HANDED_OVER: "handed over",
    Reason.DELIVERED: "delivered",
    Reason.KEPT: "done as promised",
    Reason.LATE: "done later than promised",
    Reason.NOT_CONFIRMED: "put down, and its coordinator does not answer",
    Reason.SILENT: "silent",
    Reason.IN_ERROR: "in error, and not helped in time",
    Reason.STALLED: "does not come nearer",
    Reason.OVERDUE: "long past its promise",
    Reason.NOT_COUNTED: "its load was not counted where it was to go",
    Reason.DISPUTED: "perhaps there, and not counted: somebody has to look",
    Reason.FORGOTTEN: "has forgotten it",
    Reason.BROKEN: "broken",
    Reason.GRACEFUL_SHUTDOWN: "graceful shutdown",
    Reason.OUT_OF_SERVICE: "out of service",
    Reason.PROBLEM: "in error",
    Reason.STOPPED: "stopped by an operator",
    Reason.ON_MESH: "on the radio mesh",
    Reason.HAS_WORK: "has work of its own",
    Reason.UNABLE: "could not take it over",
    Reason.DOCK_HELD: "waited too long at the source",
    Reason.SOURCE_SILENT: "the station of the source does not answer",
    Reason.COORDINATOR_SILENT: "its machine does not answer",
    Reason.CLOSED: "what is closed leaves no way",
    Reason.WAY_BLOCKED: "a silent vehicle is in the way",
    Reason.GATE_REFUSED: "the gate has not let the load in",
    Reason.OTHER_LOAD: "another load is on board",
    Reason.LOAD_GONE: "its load was taken off",
    Reason.LOAD_UNKNOWN: "nobody knows of its load",
    Reason.SUPERSEDED: "superseded",
    Reason.WITHDRAWN: "withdrawn",
    Reason.RELEASED: "released",
    Reason.NOT_NEEDED: "not needed any more",
    Reason.TASK_ENDED: "the task has ended",
    Reason.NO_ANSWER: "no answer in time",
    Reason.NOT_ASKED: "asked no more",
    Reason.ANOTHER_CARRIES: "another one carries it",
    Reason.ANOTHER_WATCHES: "another one watches",
    Reason.ANOTHER_TOOK_OVER: "another one has taken over",
    Reason.LOAD_ABOARD: "the load is on board",
    Reason.LOAD_DOWN: "the load is down",
    Reason.IS_HEARD: "the primary is heard",
    Reason.BROUGHT_BACK: "its load was brought back",
    Reason.HANDED_BY_PERSON: "a person hands its load over",
    Reason.CLOCK_WRONG: "its clock is wrong",
    Reason.RENEWED: "awarded again",
    Reason.RESIGNED: "resigned",
    Reason.TAKEN_OVER: "taken over",
    Reason.OVER: "the primary does not name it any more",
}

REFUSALS: Mapping[CommandRefusal, str] = {
    CommandRefusal.NOT_GRANTED: "nobody has granted it: it carries no grant",
    CommandRefusal.NOT_TRUSTED: "its grant is not signed by anybody whom it trusts, or not for these words",
    CommandRefusal.EXPIRED: "its grant has expired; give the command again",
    CommandRefusal.NOT_HERE: "it is outside of the areas that its grant names",
    CommandRefusal.NOT_STOPPED: "it is not stopped",
    CommandRefusal.NOT_ACKNOWLEDGED: "acknowledge the stop first",
    CommandRefusal.FAULTY: "its sensors still report a problem",
    CommandRefusal.NOT_FAULTY: "its sensors report no problem",
    CommandRefusal.IN_SERVICE: "it is in service",
    CommandRefusal.CHARGED: "its battery is as full as it is ever charged",
    CommandRefusal.NOT_STRANDED: "the goods of that transport do not wait for a word",
    CommandRefusal.NOT_HELD: "nobody has to look for the load of that transport",
    CommandRefusal.NO_SUCH_NODE: "no vehicle can be sent to that node",
    CommandRefusal.NOT_WAITING: "it has no task and no goal that waits for help",
    CommandRefusal.NOT_SUPPORTED: "that cannot be done here",
    CommandRefusal.LOAD_ABOARD: "it has goods on board, and nobody else can carry them: take them off first",
    CommandRefusal.WAIT_OUT_OF_RANGE: f"say when you are there: above 0 and at most {PROMISE_MAX_S:.0f} s from now",
    CommandRefusal.SPEED_OUT_OF_RANGE: "a speed is above 0 and at most 1 of its own; a vehicle is stopped with stop",
    CommandRefusal.QUANTITY_OUT_OF_RANGE: "so many pieces cannot be said at once",
    CommandRefusal.UNLIKELY: "far from the number that was expected; say that you are sure",
    CommandRefusal.NOT_HANDLED: "that item is neither made nor used there",
    CommandRefusal.NO_LOAD: "no load of that vehicle waits for a word",
    CommandRefusal.DOCK_OPEN: "a vehicle is loading or unloading it; count when it has gone",
    CommandRefusal.NOT_ADMITTED: "so many pieces of that goal are not let in",
}

IMPLAUSIBLE: Mapping[Implausible, str] = {
    Implausible.CLOCK: "words by a clock that is wrong",
    Implausible.NOT_A_NUMBER: "a bid that is not a number",
    Implausible.NEGATIVE: "a bid with a negative part",
    Implausible.OTHER_WORK: "a bid for another kind of work",
    Implausible.OTHER_SOURCE: "a bid with a source that was not asked for",
    Implausible.TOO_CHEAP: "a bid below the way as the crow flies",
    Implausible.TOO_SOON: "a bid that would be done sooner than any vehicle could",
    Implausible.BEFORE_NOW: "a bid that would be done in the past",
    Implausible.TOO_LATE: "a bid that would be done much later than its price tells",
}

REMOVAL_REFUSALS: Mapping[RemovalRefusal, str] = {
    RemovalRefusal.NOT_TRUSTED: "the report's signature is not trusted: compare the keys of gateway and machine",
    RemovalRefusal.EXPIRED: "the report had expired when it came: compare the clocks of gateway and machine",
    RemovalRefusal.NO_PLACE: "the place where the vehicle is put back is not in its plant file",
    RemovalRefusal.NOT_THERE: "the vehicle was heard last, or is put back, outside of the areas of whoever has reported it: "
    "somebody for these areas has to report it",
    RemovalRefusal.TOO_EARLY: "it has not listened to the vehicle for long enough",
    RemovalRefusal.IS_HEARD: "it still hears the vehicle: switch it off",
    RemovalRefusal.HEARD_SINCE: "it has heard the vehicle after the report: look again, and report it anew",
}

HELD_UP: Mapping[WaitKind, str] = {
    "silent": "which is not heard",
    "stopped": "which was stopped",
    "error": "which is in error",
    "closed": "which has no way left by what is closed",
    "charging": "which is charging",
    "standing": "which stands there",
    "moving": "which is driving",
    "unanswered": "which makes room or has no answer yet",
}
"""What blocks the last vehicle of a chain, unless it is at a dock."""

ALONE: Mapping[WaitKind, str] = {
    "closed": "has no way left by what is closed",
    "unanswered": "makes room or has no answer yet",
}
"""Words for a vehicle that waits for nobody."""

ANOTHERS_KEY = "anothers_key"
"""Reason for the fact `NameMisused`, which has none of its own."""

ROBS_PLACES = "robs_places"
"""Reason for the fact `BookRefused`, which has none of its own."""

DOCK_FAILS = "dock_fails"
"""Reason for a transport that its carriers could not load or unload (`TaskBrief.fails_at`)."""

_WORDS: Mapping[str, str] = {
    ANOTHERS_KEY: "requests places without this vehicle's signature",
    ROBS_PLACES: "keeps a reservation table that was not copied: it takes places from vehicles without their word, "
    "or has a higher number than any reservation table can have",
    DOCK_FAILS: "vehicles fail to load or unload it: somebody has to look at the dock",
    **{reason.value: words for reason, words in (*REASONS.items(), *IMPLAUSIBLE.items())},
}


def reason_text(reason: str) -> str:
    """A reason in words; reasons unknown to this version stay as they are."""
    return _WORDS.get(reason, reason.replace("_", " "))


def refusal_text(answer: CommandAnswered) -> str:
    """Why a vehicle refused a command; empty when it obeyed."""
    if answer.reason is None:
        return answer.detail
    words = REFUSALS[answer.reason]
    return f"{words}: {answer.detail}" if answer.detail else words


def wait_text(cause: WaitCauseView) -> str:
    """Which vehicles a vehicle waits for: "waits for ATV3, which waits for ATV7 at the dock of M8"."""
    if not cause.chain:
        return ALONE.get(cause.kind, "waits")
    *named, last = cause.chain
    if cause.more:
        named.append(f"{cause.more} more")
    return "waits for " + ", which waits for ".join((*named, _last(last, cause)))


def jam_text(vehicles: Sequence[str], cause: WaitCauseView) -> str:
    """The vehicles in a jam and what blocks them: "ATV5, ATV3, ATV2 wait for ATV7 at the dock of M8"."""
    names = ", ".join(vehicles)
    if cause.kind == "circle":
        return f"{names} wait in a circle: {', for '.join((*cause.chain, cause.chain[0]))}"
    return f"{names} wait for {_last(cause.chain[-1], cause)}"


def _last(atv: str, cause: WaitCauseView) -> str:
    if cause.kind == "circle":
        return f"{atv}, in a circle"
    if cause.kind == "docked":
        return f"{atv} at the dock of {cause.place}" if cause.place else f"{atv} at a dock"
    if cause.place:
        return (
            f"{atv}, which is charging at {cause.place}"
            if cause.kind == "charging"
            else f"{atv}, which stands at {cause.place}"
        )
    return f"{atv}, {HELD_UP[cause.kind]}"


def detail_of(detail: str) -> CauseView | None:
    """An agent's or person's own words as a cause; None without any."""
    return told(CauseView(detail=detail)) if detail else None


def trouble_of(task: TaskBrief) -> CauseView | None:
    """Why a transport does not go on, by its coordinator's word."""
    if task.trouble is None:
        return None
    return told(CauseView(reason=DOCK_FAILS if task.fails_at else task.trouble.value, detail=task.detail))


def failures_of(fact: GoalWaits) -> CauseView:
    """Why no machine makes a goal."""
    return told(
        CauseView(machines=tuple(FailureView(each.machine, each.reason.value) for each in fact.machines))
    )


def told(cause: CauseView) -> CauseView:
    """The same cause with its English words."""
    text = "; ".join(filter(None, (_what(cause), cause.detail)))
    cause.text = text if cause.times == 1 else f"{text} ({cause.times} times)"
    return cause


def _what(cause: CauseView) -> str:
    if cause.not_made:
        return f"this plant does not make {' and '.join(cause.not_made)}"
    if cause.machines:
        return ", ".join(f"{each.agent} is {reason_text(each.reason)}" for each in cause.machines)
    if cause.lacks:
        return f"for {'; '.join(map(_lack, cause.lacks))}"
    if cause.wait is not None:
        return wait_text(cause.wait)
    if cause.handover is not None:
        load = cause.handover
        return f"says {load.said} of {load.item} to {load.where}, counted {load.counted}"
    if cause.clock_ahead_s:
        return f"clock wrong by {cause.clock_ahead_s:+.0f} s"
    # An agent's own words say more than the bare fact of a problem.
    return "" if cause.reason == Reason.PROBLEM and cause.detail else reason_text(cause.reason)


def _lack(lack: LackView) -> str:
    return MaterialWait(item="", quantity=0, short=lack.short, silent=lack.silent).told(lack.material)
