"""The English sentence for a `WhyView`. Panels have their own, in their reader's language."""

from __future__ import annotations

from collections.abc import Sequence

from dray.gateway.live.reasons import reason_text
from dray.gateway.live.views import PassedView, RefusedView, WhyView
from dray.messages import Reason

PASSED_NAMED = 2
"""Maximum bidders passed over that are named; more would turn a sentence into a list."""

MINUTES_FROM_S = 120.0
"""Seconds from which a duration is shown in minutes."""

ANSWERS = {
    "busy": "was busy by then",
    "queue": "had taken on other goals in the meantime",
    "silent": "did not answer",
    "late": "bid only after the window had closed",
    "asked": "has not answered",
    "battery": "no longer had the battery for it",
    "deadline": "could no longer be there in time",
    "no_way": "no longer had a way there",
    "closed": "had no way left but closed ones",
    "not_fit": "was no longer fit to drive",
    "ability": "cannot carry it",
    "watching_enough": "watched enough others",
    "is_primary": "carried it already",
}

REFUSALS = {
    "busy": "busy",
    "battery": "with too little battery",
    "deadline": "too late for the deadline",
    "ability": "unable to carry it",
    "no_way": "without a way there",
    "closed": "with no way but closed ones",
    "not_fit": "takes no work at present",
    "watching_enough": "watching enough others",
    "is_primary": "carrying it already",
}

TIES = {
    "price": "its price was lower by a hair",
    "finish": "it would be done earlier",
    "name": "its name comes first, which decides between equals",
}

PARTS = {
    "empty_way": "its shorter empty way",
    "loaded_way": "its shorter loaded way",
    "energy": "the energy it needs and has left",
    "suitability": "being needed less for other work",
    "waiting": "having to wait less where it loads and unloads",
    "reliability": "contracts that the other has dropped lately",
    "queue": "its shorter queue",
    "material": "having its material sooner",
    "making": "making them faster",
    "passed": "keeping less other work waiting",
}


def why_text(why: WhyView) -> str:
    """The whole reason in one sentence or a few."""
    return " ".join(filter(None, (_main(why), _before(why), _rounds(why))))


def _main(why: WhyView) -> str:
    match why.kind:
        case "withdrawn":
            return f"{why.coordinator} has withdrawn it."
        case "unknown":
            return f"{why.agent} carries it; its bid is not on record."
        case "recovered":
            found = f"{why.coordinator} found it at work when it was back"
            return (
                f"{why.agent} carries it because it had accepted while {why.coordinator} was away: {found}."
            )
        case "took_over":
            return _took_over(why)
        case "waiting":
            return _waiting(why)
        case "asked":
            return f"{why.agent} is being asked; it bid {_s(why.total_s)}."
        case "leading":
            bids = "the only bid" if why.left == 1 else f"the cheapest of {why.left} bids"
            return f"{why.agent} leads with {bids} so far ({_s(why.total_s)})."
        case _:
            return _chosen(why)


def _chosen(why: WhyView) -> str:
    passed = _passed(why.passed, why.coordinator)
    if why.kind == "only":
        because = "nobody cheaper was left" if why.passed else "nobody else bid"
        if why.bidders > 1 and not why.passed:
            because = "it bid the least, and nobody else was left"
        return f"{why.agent} was chosen because {because} ({_s(why.total_s)}){passed}.{_refused(why.refused)}"
    of = f"the {why.left} that were left" if why.passed else f"{why.bidders} that bid"
    if why.kind == "tie":
        same = f"it and {why.other} bid the same ({_s(why.total_s)}), and {TIES[why.tie_by]}"
        return f"{why.agent} was chosen among {of} because {same}{passed}."
    by = f"{_s(why.total_s)}, {_s(why.by_s)} less than {why.other}"
    main = f"{why.agent} was chosen because it was the cheapest of {of} ({by}){passed}."
    if not why.part:
        return main
    return f"{main} Most of the difference comes from {PARTS.get(why.part, why.part)}."


def _passed(passed: Sequence[PassedView], coordinator: str) -> str:
    if not passed:
        return ""
    named = [
        f"{each.agent} was {_cheaper(each.less_s)} but {_answer(each, coordinator)}"
        for each in passed[:PASSED_NAMED]
    ]
    if rest := len(passed) - len(named):
        named.append(f"{rest} more cheaper {'one' if rest == 1 else 'ones'} dropped out too")
    return "; " + "; ".join(named)


def _cheaper(less_s: float) -> str:
    return f"{_s(less_s)} cheaper" if less_s else "just as cheap"


def _answer(each: PassedView, coordinator: str) -> str:
    if each.taken_for == coordinator:
        return f"had been taken for another transport of {coordinator} in the meantime"
    if each.taken_for:
        return f"had been taken by {each.taken_for} in the meantime"
    return ANSWERS.get(each.answer, f"declined ({each.answer.replace('_', ' ')})")


def _took_over(why: WhyView) -> str:
    if why.reason == Reason.SILENT and why.silent_s > 0:
        failed = f"nothing had been heard of {why.replaced} for {_s(why.silent_s)}"
    else:
        failed = f"{why.replaced} had failed ({reason_text(why.reason) or 'no reason is on record'})"
    main = f"{why.agent} watched over it and took it over because {failed}"
    return f"{main}." if why.confirmed else f"{main}; {why.coordinator} has not confirmed that yet."


def _waiting(why: WhyView) -> str:
    if not why.passed:
        return f"Nobody has bid yet.{_refused(why.refused)}"
    asked = "; ".join(f"{each.agent} {_answer(each, why.coordinator)}" for each in why.passed[:PASSED_NAMED])
    if (rest := len(why.passed) - PASSED_NAMED) > 0:
        asked += f"; {rest} more dropped out"
    return f"All that bid were asked in vain: {asked}.{_refused(why.refused)}"


def _refused(refused: Sequence[RefusedView]) -> str:
    """The number of refusals, by reason."""
    count = sum(len(each.agents) for each in refused)
    if not count:
        return ""
    if count == 1:
        (only,) = refused
        return f" {only.agents[0]} refused: {_reason(only)}."
    if len(refused) == 1:
        return f" {count} refused for the same reason: {_reason(refused[0])}."
    reasons = ", ".join(f"{_reason(each)} ({len(each.agents)})" for each in refused)
    return f" {count} refused: {reasons}."


def brief(detail: str) -> str:
    """An agent's words without their particulars, which follow a colon."""
    return detail.partition(":")[0]


def _reason(refused: RefusedView) -> str:
    if refused.detail:
        return brief(refused.detail)
    return REFUSALS.get(refused.reason, refused.reason.replace("_", " "))


def _before(why: WhyView) -> str:
    """The carrier before the new announcement."""
    if not why.replaced or why.kind == "took_over":
        return ""
    silent = why.reason == Reason.SILENT and why.silent_s > 0
    reason = f"silent for {_s(why.silent_s)}" if silent else reason_text(why.reason)
    return f"It was announced anew because {why.replaced} could not go on with it ({reason})."


def _rounds(why: WhyView) -> str:
    if why.round < 2 or why.kind in {"took_over", "recovered", "unknown", "withdrawn"}:
        return ""
    within = f"; the last one asked within {why.radius_m:.0f} m" if why.radius_m > 0 else ""
    if why.kind not in {"waiting", "leading", "asked"}:
        return f"It took {why.round} rounds{within}."
    asks = f", which asks within {why.radius_m:.0f} m" if why.radius_m > 0 else ""
    return f"This is round {why.round}{asks}."


def _s(seconds: float) -> str:
    """A duration: tenths distinguish vehicles' prices, but mean nothing for hours of production."""
    if seconds < MINUTES_FROM_S:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    return f"{whole // 60}:{whole % 60:02d} min"
