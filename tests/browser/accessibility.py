"""What a page does to people who see, hear or move otherwise: axe-core, with the rules of WCAG 2.2 AA.

axe is handed to the page by the debugger's protocol, so the page's content policy stays as it is.
"""

from __future__ import annotations

from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any
from weakref import WeakSet

from playwright.sync_api import Page
from playwright.sync_api import TimeoutError as NeverShown

AXE = Path(__file__).resolve().parents[2] / "frontend/node_modules/axe-core/axe.min.js"

RULES = ("wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice")
"""Level A and AA of all versions up to 2.2, and what axe's authors advise beyond them."""

RUN = """rules => axe.run(document, {
    runOnly: { type: "tag", values: rules }, resultTypes: ["violations"], preload: { assets: ["media"] },
}).then(found => found.violations)"""

ELEMENTS_SHOWN = 3
"""Of the elements that break one rule: enough to see what they have in common."""


AUDITED: WeakSet[Page] = WeakSet()
"""Pages that have been looked at in some state of theirs."""


@cache
def _axe() -> str:
    return AXE.read_text(encoding="utf-8")


def violations(page: Page) -> list[str]:
    """What the page, as it is now, breaks: one line per rule, with the first elements that do."""
    AUDITED.add(page)
    _wait_until_shown(page)
    # Half a megabyte of script: once per page is enough.
    if not page.evaluate("'axe' in window"):
        page.evaluate(_axe())
    return [_line(page, rule) for rule in page.evaluate(RUN, list(RULES))]


def _wait_until_shown(page: Page) -> None:
    """Wait for what a page's script puts into it, which may come after the page counts as loaded."""
    with suppress(NeverShown):  # a page that shows nothing is one of the things that axe tells of
        page.wait_for_selector("main", state="attached")


def _line(page: Page, rule: dict[str, Any]) -> str:
    elements = "; ".join(
        f"{' '.join(map(str, node['target']))} ({_reason(node)})" for node in rule["nodes"][:ELEMENTS_SHOWN]
    )
    return f"{page.url}: {rule['id']} ({rule['impact']}), {len(rule['nodes'])} times: {elements}"


def _reason(node: dict[str, Any]) -> str:
    return " ".join(check["message"] for check in (*node["any"], *node["all"], *node["none"]))
