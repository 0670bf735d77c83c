"""Kinds of problems of the gateway over REST, as its sources name them."""

from __future__ import annotations

import ast
from pathlib import Path

STATUS = ("HTTPStatus.", "status")
"""How the first argument of a problem begins."""

GATEWAY = Path(__file__).parents[3] / "backend" / "dray" / "gateway"

OF_PROGRAMS = frozenset(
    {
        # What no panel does: it sends JSON under known addresses, with versions, keys of its own and parameters that there are.
        *("command-name-used", "key-used", "method-not-allowed", "no-rule", "no-version", "not-called-form"),
        *("not-called-json", "not-found", "not-json", "not-ready", "odd-precondition", "unknown-host"),
        *("unknown-parameter", "unknown-plan"),
        # Told by the server's own pages, or with times and fields that the kind alone does not tell.
        *("not-logged-in", "too-late", "too-many-logins", "too-many-tries", "tracking-link-ended"),
        *("unknown-tracking-page", "unusable-fields", "wrong-login", "login-link-used-up"),
    }
)
"""Those that no panel tells in its own words."""


def problem_kinds() -> set[str]:
    """Kinds of problems that the gateway names."""
    texts = [path.read_text(encoding="utf-8") for path in GATEWAY.rglob("*.py")]
    # Parsing all of the gateway would take half a second of each of pytest's processes.
    trees = [ast.parse(text) for text in texts if "Problem(" in text or "(Problem)" in text]
    calls = [node for tree in trees for node in ast.walk(tree) if isinstance(node, ast.Call)]
    named = [call for call in calls if ast.unparse(call.func) in ("Problem", "super().__init__")]
    named = [call for call in named if call.args and ast.unparse(call.args[0]).startswith(STATUS)]
    second = [call.args[1] for call in named if len(call.args) > 1]
    return {str(each.value) for each in second if isinstance(each, ast.Constant)}
