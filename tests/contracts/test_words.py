"""One word for one thing: words that must not come back, because the field has a better one.

The left column is a pattern of a word that was once used; the right one is what the field says. A word that is plain
English elsewhere is looked for only as a name (of a class, a function, a module), and may be allowed in places that
are listed with the reason.
"""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

DESK = r"\b[Dd]esks?\b"
TRIAL = r"\b[Tt]rials?\b"
PASSERBY = r"\b[Pp]asserby\b"
REGRET = r"\b[Rr]egrets?\b"

WORDS = {
    DESK: "outbox, stop sender, order client",
    TRIAL: "probation, run, fault injection, canary",
    PASSERBY: "random operator",
    REGRET: "canceller",
    r"[Ii]nsistence": "retransmitter",
    r"(?<![A-Za-z])vigil(?![a-z])|Vigil\b": "failure detector",
    r"\bearshot": "cell subscription",
    r"\b[Hh]eirs?\b": "standby candidate",
    r"\bvetoe?[sd]?\b": "objection",
    r"\bGRACE(_S)?\b": "takeover time-out",
    r"\b[Bb]erths?\b": "dwell points",
    r"\b[Oo]bedience\b": "command handling",
    r"\b[Cc]arriages?\b": "transport job",
    r"(?i:adopt)": "recovery, acknowledge",
    r"\b(ASTRAY_S|astray)\b": "lost in transit",
    r"\b[Nn]ewcomers?\b": "joining agent, first users",
    r"(?i:\broll[-_ ]?calls?(?![a-z]))": "reconciliation, recovery poll, agents present",
    r"\b[Ll]ookout\b": "database sync",
    r"\b[Mm]uster(ed|ing)\b": "supervisor",
    r"\b(leaves?|left|leaving|away) in order\b": "graceful shutdown",
    r"\b(StopDesk|StopDoor|StopBook)\b": "stop sender, endpoint, recorder",
    r"\bclass (Core|Pulse|Newest|Hearing|Following|Departure|Trouble|Trial|Rest|Aside|Seeking|Desk|Office)\b": (
        "agent base, heartbeat timer, bounded map, arrival statistics, heartbeat subscriptions, graceful shutdown, "
        "assistance, probation, idle positioning, waiting places, work search, order client, gateway process"
    ),
    r"\bdef (hear|hear_\w+)\(": "on_bid, on_award, on_heartbeat: the name says what came",
}
"""What nobody may write anywhere: in code, comments, docs, panels and tests."""

SEEDS = "a name on the bus or of a random generator: another one would be another run of every seed"
SCREEN = "a desk, beside a telephone and a tablet"
EXAMPLE = "any name will do"

ALLOWED = {
    (DESK, "sim/dray_sim/people/order_client.py"): SEEDS,
    (DESK, "sim/dray_sim/faults/names.py"): SEEDS,
    (DESK, "tests/simulation/checks/"): SEEDS,
    (DESK, "tests/protocol/runtime/test_agent_base.py"): EXAMPLE,
    (DESK, "tests/gateway/access/test_sessions.py"): SCREEN,
    (DESK, "tests/gateway/factory/test_alerts_taken.py"): "the control room's",
    (DESK, "tests/browser/"): SCREEN,
    (DESK, "sim/dray_sim/bench/panels/browser.py"): SCREEN,
    (DESK, "frontend/src/"): SCREEN,
    (TRIAL, "sim/dray_sim/explore/run.py"): SEEDS,
    (PASSERBY, "sim/dray_sim/explore/play.py"): SEEDS,
    (PASSERBY, "sim/dray_sim/people/random/random_operator.py"): SEEDS,
    (REGRET, "sim/dray_sim/explore/run.py"): SEEDS,
    (REGRET, "sim/dray_sim/people/random/canceller.py"): SEEDS,
}
"""A word, where it stays all the same, and why."""

MODULES = frozenset(
    [
        "insistence",
        "departure",
        "leaving",
        "vigil",
        "hearing",
        "following",
        "heir",
        "veto",
        "grace",
        "berths",
        "resting",
        "earshot",
        "obedience",
        "trouble",
        "carriage",
        "adoption",
        "goods",
        "astray",
        "trial",
        "trials",
        "newcomers",
        "desk",
        "door",
        "rollcall",
        "endings",
        "intake",
        "lookout",
        "recall",
        "presence",
        "shields",
        "onward",
        "trail",
        "sight",
        "seen",
        "scenes",
        "early",
        "troubles",
        "muster",
        "roll",
        "posts",
        "keeper",
        "judge",
        "books",
        "book",
        "bookkeeping",
        "book_keeper",
        "wishes",
        "wish_keys",
        "roll_call",
        "late_tellers",
        "said_and_heard",
        "told_stock",
        "stock_told",
        "office",
        "front",
        "ears",
        "passerby",
        "regret",
        "calm",
        "blame",
        "bonds",
        "company",
    ]
)
"""What no module of Python may be called."""

PAIRS = ("backend/dray/protocol/",)
"""Where no function is called `begin` or `end`: its name says what begins."""


@pytest.fixture(scope="module")
def texts() -> dict[str, str]:
    """Everything that people write here, by its path."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    ).stdout.splitlines()
    kinds = {".py", ".md", ".ts", ".tsx", ".json", ".html", ".yml", ".toml"}
    return {
        path: (ROOT / path).read_text(encoding="utf-8")
        for path in listed
        if Path(path).suffix in kinds
        and (ROOT / path).is_file()
        and not (ROOT / path).is_symlink()
        and not path.endswith(("package-lock.json", "tests/contracts/test_words.py"))
    }


@pytest.mark.parametrize("word", WORDS)
def test_a_word_that_the_field_has_a_better_one_for_stays_away(word: str, texts: dict[str, str]) -> None:
    assert len(texts) > 500
    found = [
        f"{path}:{text.count(chr(10), 0, match.start()) + 1}: {match[0]}: say {WORDS[word]}"
        for path, text in texts.items()
        for match in re.finditer(word, text)
        if not any(allowed == word and path.startswith(place) for allowed, place in ALLOWED)
    ]
    assert found == []


def test_no_place_is_allowed_a_word_that_it_does_not_use(texts: dict[str, str]) -> None:
    unused = [
        (word, place)
        for word, place in ALLOWED
        if not any(path.startswith(place) and re.search(word, text) for path, text in texts.items())
    ]
    assert unused == []


def test_no_module_is_called_by_such_a_word(texts: dict[str, str]) -> None:
    modules = {path for path in texts if path.endswith(".py") and path.startswith(("backend/", "sim/"))}
    assert len(modules) > 400
    assert [path for path in modules if Path(path).stem in MODULES] == []


def test_in_the_protocol_a_name_says_what_begins_and_what_ends(texts: dict[str, str]) -> None:
    found = [
        f"{path}: {match[0]}"
        for path, text in texts.items()
        if path.startswith(PAIRS)
        for match in re.finditer(r"\bdef (begin|end)\(", text)
    ]
    assert found == []
