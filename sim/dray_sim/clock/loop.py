"""Virtual time on asyncio: a clock that jumps, or runs at a chosen multiple of real time.

The rule: nothing takes time but waiting. While a callback or a task runs, the clock stands. When nothing is ready any
more, the clock goes to the next scheduled instant.

Theory of operation. `VirtualClock` holds one heap of scheduled calls; `VirtualLoop` is an asyncio event loop that
takes its time from it. One step of the loop runs all entries of the next instant, in the order of their times and,
within one instant, of their scheduling. Then it runs tasks until none is ready. `asyncio.sleep`, `wait_for` and
`call_later` are entries of the same heap, so agents and bodies share one order for every kind of callback.

The two paces differ only in when an instant may begin: at once (`JUMP`), or when real time has reached it (`paced`).
Both therefore give the same order of events, as long as there is no input from outside.

The simulated things themselves are left to other modules.
"""

# An event loop of one's own means working with asyncio's private parts: handles and the ready queue.
# ruff: noqa: SLF001

from __future__ import annotations

import asyncio
import heapq
import math
import time
from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from itertools import count
from typing import TYPE_CHECKING, Any, TypeVar

from dray.errors import ProtocolViolation

if TYPE_CHECKING:
    import contextvars
    from collections import deque
    from selectors import BaseSelector

T = TypeVar("T")

Entry = tuple[float, int, Callable[..., object], tuple[Any, ...]]
"""When (s), the number of the call, the callback and its arguments. The number makes ties fair."""

MAX_STEPS_PER_INSTANT = 1_000_000
"""Callbacks and task steps in one instant. The start of a thousand agents takes some ten thousand. A million means
that some code asks to be called back at once, again and again."""

MAX_SELECT_S = 3600.0
"""Longest sleep in the selector: a longer one overflows on some systems (asyncio caps it likewise)."""

BURST_S = 0.005
"""Longest real time in which a paced loop works off due instants before it polls its sockets. It is shorter than a
person notices, and much longer than the 3 us of a poll."""

TICK_S = 1e-9
"""A shorter real time counts as reached: rounding must not cost a sleep of zero length."""

STANDS_FROM_S = 1.0
"""Real seconds that a paced loop catches up with; one that is further behind may stand instead (`VirtualLoop.stood`)."""

MIN_CANCELLED = 100
"""Cancelled asyncio timers that are not worth a clean-up of the heap (as in asyncio)."""


class DeadlockError(ProtocolViolation):
    """Virtual time cannot go on: everybody waits, and nothing is left that could happen."""

    def __init__(self, now_s: float, waiting: int) -> None:
        self.now_s, self.waiting = now_s, waiting
        super().__init__(
            f"deadlock at {now_s:.6f} s of virtual time: {waiting} tasks wait and nothing is scheduled "
            "that could wake them; give the run an end, or wake the task that it waits for"
        )


class StandstillError(ProtocolViolation):
    """Virtual time does not go on: something asks to be called back at once, again and again."""

    def __init__(self, now_s: float, callback: object) -> None:
        self.now_s, self.callback = now_s, callback
        super().__init__(
            f"virtual time stands at {now_s:.6f} s after {MAX_STEPS_PER_INSTANT} steps, the last one of "
            f"{callback!r}; whoever wakes up must ask for a later time than now"
        )


@dataclass(frozen=True, slots=True)
class Pace:
    """Relation of virtual time to real time.

    Attributes:
        speed: virtual seconds per real second; infinite for as fast as possible.
    """

    speed: float

    def __post_init__(self) -> None:
        if not self.speed > 0.0:
            raise ValueError(f"speed must be above 0, not {self.speed!r}")


JUMP = Pace(math.inf)
"""As fast as possible; without sockets and other threads, for nothing exists outside."""


def paced(speed: float) -> Pace:
    """`speed` virtual seconds per real second; sockets and other threads are served meanwhile."""
    return Pace(speed)


class VirtualClock:
    """A clock that stands still until its loop moves it on (see `dray.ports.Clock`).

    Attributes:
        time_s: now. Only the loop writes it, and it never goes back.
        heap: the scheduled calls. Only this class pushes, and only the loop pops.
    """

    __slots__ = ("_numbers", "heap", "time_s")

    def __init__(self, start_s: float = 0.0) -> None:
        self.time_s = start_s
        self.heap: list[Entry] = []
        self._numbers = count()

    def now_s(self) -> float:
        """Virtual seconds; never goes back."""
        return self.time_s

    def call_at(self, when_s: float, callback: Callable[..., object], *args: Any) -> None:
        """Call `callback(*args)` at `when_s`; a time that is past means now, infinity means never.

        Raises:
            ValueError: `when_s` is not a number; it would destroy the order of the heap.
        """
        if not self.time_s <= when_s < math.inf:
            if math.isnan(when_s):
                raise ValueError(f"call_at: the time for {callback!r} is not a number")
            if when_s == math.inf:
                return
            when_s = self.time_s
        heapq.heappush(self.heap, (when_s, next(self._numbers), callback, args))


class _Handle(asyncio.Handle):
    """A handle without the bookkeeping of asyncio's debug mode: it is made for every task step."""

    __slots__ = ()

    def __init__(
        self,
        callback: Callable[..., object],
        args: tuple[Any, ...],
        loop: asyncio.AbstractEventLoop,
        context: contextvars.Context | None,
    ) -> None:
        if context is None:
            super().__init__(callback, args, loop)
            return
        self._context = context
        self._loop = loop
        self._callback = callback
        self._args = args
        self._cancelled = False
        self._repr = None
        self._source_traceback = None


class _Timer(asyncio.TimerHandle):
    """A timer whose `_scheduled`, asyncio's own mark of being on a heap, is known to the type checker."""

    __slots__ = ()
    _scheduled: bool


class VirtualLoop(asyncio.SelectorEventLoop):
    """An asyncio event loop in virtual time.

    An exception from a clock's callback ends the run: a factory with a broken part proves nothing.
    Callbacks of asyncio itself keep asyncio's custom, the loop's exception handler.

    Args:
        pace: `JUMP` or `paced(speed)`; real time counts from `begin`, or from the loop's first idle moment, so that
            building a factory takes no virtual time.
        start_s: the clock's first reading.
        selector: for tests; the system's best one by default.
        wall_s: real time in seconds that never goes back; for tests.

    Attributes:
        clock: the `dray.ports.Clock` of all that run on the loop.
        lag_s: how far a paced loop is behind real time, in real seconds; 0 when it keeps up.
        steps: callbacks and task steps so far.
        stood: None, and a paced loop catches up with real time after any delay. Otherwise the clock stands still when
            the delay exceeds `STANDS_FROM_S`, and at every input from outside. So by the clock on the wall nothing
            happens before its cause. The loop calls this with the real seconds for which it has stood.
    """

    _ready: deque[asyncio.Handle]
    _stopping: bool
    _selector: BaseSelector
    _process_events: Callable[[list[Any]], None]

    def __init__(
        self,
        pace: Pace = JUMP,
        start_s: float = 0.0,
        *,
        selector: BaseSelector | None = None,
        wall_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self.clock = VirtualClock(start_s)
        self.pace = pace
        self.lag_s = 0.0
        self.steps = 0
        self.stood: Callable[[float], None] | None = None
        self._cancelled_timers = 0
        self._wall_s = wall_s
        self._start_s = start_s
        self._start_wall_s: float | None = None
        super().__init__(selector)

    # --- what asyncio asks of a loop -------------------------------------------------------------

    def time(self) -> float:
        """Virtual seconds."""
        return self.clock.time_s

    def call_at(  # type: ignore[override]
        self,
        when: float,
        callback: Callable[..., object],
        *args: Any,
        context: contextvars.Context | None = None,
    ) -> asyncio.TimerHandle:
        """Like asyncio's, on the heap of the clock."""
        timer = _Timer(when, callback, args, self, context)
        timer._scheduled = True
        if self._cancelled_timers > MIN_CANCELLED and self._cancelled_timers * 2 > len(self.clock.heap):
            self._forget_cancelled_timers()
        self.clock.call_at(when, self._run_timer, timer)
        return timer

    def call_soon(  # type: ignore[override]
        self,
        callback: Callable[..., object],
        *args: Any,
        context: contextvars.Context | None = None,
    ) -> asyncio.Handle:
        """Like asyncio's, without its debug mode and its check for a closed loop."""
        handle = _Handle(callback, args, self, context)
        self._ready.append(handle)
        return handle

    def _run_timer(self, timer: _Timer) -> None:
        if timer._cancelled:
            self._cancelled_timers -= 1
        else:
            timer._scheduled = False
            timer._run()

    def _timer_handle_cancelled(self, timer: _Timer) -> None:
        if timer._scheduled:
            self._cancelled_timers += 1

    def _forget_cancelled_timers(self) -> None:
        heap = self.clock.heap
        # Changed in place: the running loop holds on to this list.
        heap[:] = [entry for entry in heap if entry[2] != self._run_timer or not entry[3][0]._cancelled]
        heapq.heapify(heap)
        self._cancelled_timers = 0

    def _run_once(self) -> None:
        if self.pace.speed == math.inf:
            self._jump()
        else:
            self._keep_pace()

    # --- the two paces ---------------------------------------------------------------------------

    def _jump(self) -> None:
        """Run until stopped. The hot path of every simulation: one loop, no calls but the callbacks'."""
        clock, ready, pop = self.clock, self._ready, heapq.heappop
        heap = clock.heap
        steps, limit = self.steps, self.steps + MAX_STEPS_PER_INSTANT
        try:
            while not self._stopping:
                if ready:
                    # Only the handles that are ready now, so that a stop is seen though there are always more.
                    steps += len(ready)
                    for _ in range(len(ready)):
                        handle = ready.popleft()
                        if not handle._cancelled:
                            handle._run()
                    if steps > limit:
                        raise StandstillError(clock.time_s, handle)
                    continue
                if not heap:
                    raise DeadlockError(clock.time_s, len(asyncio.all_tasks(self)))
                when_s = heap[0][0]
                if when_s > clock.time_s:
                    clock.time_s = when_s
                    limit = steps + MAX_STEPS_PER_INSTANT
                while heap and heap[0][0] == when_s:
                    _, _, callback, args = pop(heap)
                    callback(*args)
                    steps += 1
                    if steps > limit:
                        raise StandstillError(clock.time_s, callback)
        finally:
            self.steps = steps

    def _keep_pace(self) -> None:
        """Sleep until something is due or comes from outside, then work for one burst at most."""
        was_idle = not self._ready
        if was_idle and self._start_wall_s is None:
            self._start_wall_s = self._wall_s()
        come = self._selector.select(self._sleep_s())
        if was_idle:
            # Inputs from outside have arrived now. Tasks of an instant still see that instant.
            self._move_on()
        if come:
            self._stand()
        self._process_events(come)
        burst_ends_s = self._wall_s() + BURST_S
        while self._step_paced() and not self._stopping and self._wall_s() < burst_ends_s:
            pass

    def _sleep_s(self) -> float:
        """Real seconds until the next instant is due."""
        if self._ready or self._stopping:
            return 0.0
        if not self.clock.heap:
            return MAX_SELECT_S
        virtual_s = self.clock.heap[0][0] - self.due_s()
        return min(max(0.0, virtual_s / self.pace.speed), MAX_SELECT_S)

    def begin(self) -> None:
        """Count real time from now: the present readings of both clocks belong together."""
        self._start_wall_s = self._wall_s() - (self.clock.time_s - self._start_s) / self.pace.speed

    def due_s(self) -> float:
        """The virtual time that belongs to this real moment (paced loops); callable from any thread."""
        if self._start_wall_s is None:
            return self._start_s
        return self._start_s + (self._wall_s() - self._start_wall_s) * self.pace.speed

    def _move_on(self) -> None:
        # Never past an instant that has not run yet: a loop that is behind catches up, it skips nothing.
        next_s = self.clock.heap[0][0] if self.clock.heap else math.inf
        self.clock.time_s = max(self.clock.time_s, min(self.due_s(), next_s))

    def _stand(self) -> None:
        """Take this moment for the one that real time has come to, where that is ahead."""
        behind_s = (self.due_s() - self.clock.time_s) / self.pace.speed
        if self.stood is None or self._start_wall_s is None or behind_s <= 0.0:
            return
        self._start_wall_s += behind_s
        self.lag_s = 0.0
        self.stood(behind_s)

    def _step_paced(self) -> bool:
        """Run ready handles, or else one due instant; False when there was neither."""
        clock, heap, ready = self.clock, self.clock.heap, self._ready
        if ready:
            self.steps += len(ready)
            for _ in range(len(ready)):
                handle = ready.popleft()
                if not handle._cancelled:
                    handle._run()
            return True
        due_s = self.due_s()
        next_s = heap[0][0] if heap else math.inf
        self.lag_s = max(0.0, due_s - next_s) / self.pace.speed
        if next_s > due_s + TICK_S:
            return False
        clock.time_s = next_s
        if self.lag_s > STANDS_FROM_S:
            self._stand()
        while heap and heap[0][0] == next_s:
            _, _, callback, args = heapq.heappop(heap)
            callback(*args)
            self.steps += 1
        return True


def run(main: Coroutine[Any, Any, T], pace: Pace = JUMP, start_s: float = 0.0) -> T:
    """Run `main` to its end in virtual time; tasks that it leaves behind are cancelled, as in asyncio.run.

    The clock is `clock()` inside.

    Raises:
        DeadlockError: (`JUMP` only) everybody waits and nothing is left that could happen.
        StandstillError: (`JUMP` only) time does not go on.
        Exception: that of `main` or of a callback of the clock.
    """
    with asyncio.Runner(loop_factory=lambda: VirtualLoop(pace, start_s)) as runner:
        return runner.run(main)


def clock() -> VirtualClock:
    """The clock of the running virtual loop.

    Raises:
        RuntimeError: no virtual loop is running in this thread.
    """
    return virtual_loop().clock


def virtual_loop() -> VirtualLoop:
    """The running virtual loop.

    Raises:
        RuntimeError: no virtual loop is running in this thread.
    """
    loop = asyncio.get_running_loop()
    if not isinstance(loop, VirtualLoop):
        raise RuntimeError("no virtual loop runs here; start one with dray_sim.clock.loop.run")  # noqa: TRY004
    return loop
