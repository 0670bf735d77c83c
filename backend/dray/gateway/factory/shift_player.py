"""Plays a shift in a draft and in the running plant for comparison, in a bounded process.

The gateway knows no simulator: it starts `dray sim run day` as a person would, and reads its report. If the
simulator is not installed, or the process exceeds its bounds, the answer says so.
"""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from http import HTTPStatus
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import msgspec

from dray.errors import DrayError
from dray.gateway.http.bounded_process import run_bounded
from dray.gateway.http.problems import Problem
from dray.plant.file.reasons import Reason, told

MOST_S = 300.0
"""Maximum wall seconds per plant; a shift of 8 h in the default plant takes some 30."""

MOST_BYTES = 2 * 1024**3
"""Maximum memory per plant."""

MOST_KEPT = 20
"""Maximum results kept of drafts; and of running plants, one per length and seed."""

TAIL_CHARS = 400
"""Maximum characters quoted of a failed process's output."""


class ShiftFigures(msgspec.Struct, frozen=True, kw_only=True):
    """The figures of a shift."""

    orders_placed: int
    orders_delivered: int
    on_time_frac: float | None
    """Fraction of the orders that were due; None if none was."""
    starvation_frac: float
    """Fraction of the machines' time with work."""
    transports_per_h: float
    waiting_frac: float
    """Fraction of the vehicles' time."""
    empty_travel_frac: float
    bottleneck: str
    """The bottleneck in words."""
    bottleneck_code: str = ""
    """Code of these words, for translation in panels."""
    bottleneck_values: dict[str, Any] = {}
    """Values for them, as in a finding."""
    bottleneck_name: str
    """The machine, dock or type of vehicle; empty if none."""
    invariants: str


class PlayView(msgspec.Struct, frozen=True, kw_only=True):
    """A requested shift."""

    state: str
    """none, playing, done or failed."""
    version: int = 0
    """Version of the draft that was played."""
    hours: float = 0.0
    seed: int = 0
    draft: ShiftFigures | None = None
    running: ShiftFigures | None = None
    """The same shift in the running plant."""
    reason: str = ""
    """Reason of a failure."""
    reason_code: str = ""
    """Code of the reason, for translation in panels; empty if the simulator gave it."""
    reason_values: dict[str, Any] = {}
    """Values for it, as in a finding."""


class PlayFailed(DrayError):
    """The process ended without a report; the text says why."""


class ShiftPlayer:
    """Plays one shift at a time.

    Args:
        running: returns the text of the running plant's file.
        command: the program to start, before the options of `dray sim run`.
        most_s: maximum wall seconds per plant.
    """

    def __init__(
        self,
        running: Callable[[], Awaitable[str]],
        command: tuple[str, ...] = (sys.executable, "-m", "dray"),
        most_s: float = MOST_S,
    ) -> None:
        self._running, self._command, self._most_s = running, command, most_s
        self._kept: dict[str, PlayView] = {}
        self._beside: dict[tuple[str, float, int], ShiftFigures] = {}
        self._task: asyncio.Task[None] | None = None

    def result(self, draft: str) -> PlayView:
        """The newest result of a draft."""
        return self._kept.get(draft, PlayView(state="none"))

    def play(self, draft: str, text: str, version: int, hours: float, seed: int) -> PlayView:
        """Start to play a plant file.

        Raises:
            Problem: 409, another one is being played.
        """
        if self._task is not None and not self._task.done():
            raise Problem(
                HTTPStatus.CONFLICT,
                "shift-being-played",
                "Another shift is being played",
                "wait until it has ended",
                headers={"Retry-After": "5"},
            )
        begun = PlayView(state="playing", version=version, hours=hours, seed=seed)
        self._keep(draft, begun)
        self._task = asyncio.get_running_loop().create_task(self._play(draft, text, begun))
        return begun

    async def close(self) -> None:
        """Stop a shift in progress."""
        if self._task is not None:
            self._task.cancel()
            with suppress(asyncio.CancelledError):
                await self._task

    async def _play(self, draft: str, text: str, begun: PlayView) -> None:
        try:
            figures = await self._figures(text, begun.hours, begun.seed)
            beside = await self._running()
            key = (beside, begun.hours, begun.seed)
            if key not in self._beside:
                if len(self._beside) >= MOST_KEPT:
                    self._beside.clear()
                self._beside[key] = await self._figures(beside, begun.hours, begun.seed)
            done = msgspec.structs.replace(begun, state="done", draft=figures, running=self._beside[key])
        except (PlayFailed, Problem) as error:
            done = _failed(begun, error.args[0])
        except (OSError, asyncio.CancelledError):
            self._keep(draft, _failed(begun, Reason("played_broken_off")))
            raise
        self._keep(draft, done)

    def _keep(self, draft: str, view: PlayView) -> None:
        self._kept.pop(draft, None)
        self._kept[draft] = view
        if len(self._kept) > MOST_KEPT:
            del self._kept[next(iter(self._kept))]

    async def _figures(self, text: str, hours: float, seed: int) -> ShiftFigures:
        with TemporaryDirectory(prefix="dray-draft-") as folder:
            plant, report = Path(folder, "plant.yaml"), Path(folder, "report.json")
            await asyncio.to_thread(plant.write_text, text, encoding="utf-8")
            options = {"--plant": plant, "--hours": hours, "--seed": seed, "--json": report}
            words = [str(word) for option in options.items() for word in option]
            said = await self._run((*self._command, "sim", "run", "day", *words))
            try:
                return figures_of(msgspec.json.decode(await asyncio.to_thread(report.read_bytes)))
            except (OSError, msgspec.DecodeError, KeyError, TypeError, ValueError):
                raise PlayFailed(said[-TAIL_CHARS:].strip() or Reason("played_no_report")) from None

    async def _run(self, command: tuple[str, ...]) -> str:
        try:
            return (await run_bounded(command, self._most_s, MOST_BYTES))[1]
        except TimeoutError:
            raise PlayFailed(Reason("played_too_long", most_s=self._most_s)) from None


def _failed(begun: PlayView, reason: str) -> PlayView:
    code = reason.code if isinstance(reason, Reason) else ""
    return msgspec.structs.replace(
        begun, state="failed", reason=str(reason), reason_code=code, reason_values=told(reason, str)
    )


def figures_of(report: Mapping[str, Any]) -> ShiftFigures:
    """The figures of a report of `dray sim run --json`."""
    verdict = report["verdict"]
    return ShiftFigures(
        orders_placed=report["orders_placed"],
        orders_delivered=report["orders_delivered"],
        on_time_frac=report["on_time_frac"] if report["orders_due"] else None,
        starvation_frac=report["starvation_frac"],
        transports_per_h=report["transports"] * 3600.0 / report["duration_s"],
        waiting_frac=report["utilisation_frac"]["waiting"],
        empty_travel_frac=report["empty_travel_frac"],
        bottleneck=verdict["text"],
        bottleneck_code=verdict.get("code", ""),
        bottleneck_values=verdict.get("values", {}),
        bottleneck_name=verdict["name"] if verdict["bottleneck"] else "",
        invariants=report["invariants"],
    )
