"""The bridge between the simulated factory's loop and an ordinary asyncio loop in another thread.

The factory runs paced in a thread of its own (`SimThread`). The gateway lives on the outer loop and is a peer on the
same network, through `BridgedBus`. The threads share only two queues, one each way. A queue wakes the other side once
for any number of entries, so a burst costs one wake-up.

The queues are bounded (see `dray.adapters.crossing`). The bridge does not interpret the messages.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
from concurrent.futures import Future
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from dray.adapters.crossing import Crossing
from dray.errors import UnavailableError
from dray.shapes import prepare_shapes
from dray_sim.clock.loop import VirtualLoop
from dray_sim.clock.wall import Wall, steady_wall

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine

    from dray.messages import Message
    from dray.ports import Bus, Receive, Session
    from dray_sim.clock.loop import Pace

T = TypeVar("T")

STOP_S = 10.0
"""Longest time that a factory takes to stop: its agents only leave the bus, which takes milliseconds."""


class BridgedSession:
    """The session of an outer agent on the simulated network.

    Joining, subscribing, unsubscribing and leaving raise `UnavailableError` where the simulation has left so
    many of them undone that it must have stopped (`Crossing.order`).
    """

    def __init__(self, bridge: BridgedBus, agent: str, receive: Receive, life: int) -> None:
        self._in, self._out = bridge.inbound, bridge.outbound
        self.life = life
        self._receive = receive
        self.context = ""
        """It crosses in neither direction: outer agents are not traced."""
        self._left = False
        self._inner: Session
        """Set by the first call that crosses, and used on the simulation's thread only."""
        self._in.order(self._join, bridge.network, agent, life)

    # --- on the outer loop -----------------------------------------------------------------------

    def publish(self, key: str, message: Message) -> None:
        """Say it to all that listen on `key`."""
        self._in.say(message, self._publish, key, message)

    def send(self, to: str, message: Message) -> None:
        """Say it to one agent alone."""
        self._in.say(message, self._send, to, message)

    def subscribe(self, key: str) -> None:
        """Receive all later messages on `key`."""
        self._in.order(self._subscribe, key)

    def unsubscribe(self, key: str) -> None:
        """Hear it no longer."""
        self._in.order(self._unsubscribe, key)

    def leave(self) -> None:
        """Leave the network; nothing is received after the return."""
        self.silence()
        self._in.order(self._leave)

    def silence(self) -> None:
        """Receive no more messages, not even those that have crossed already."""
        self._left = True

    def _arrive(self, sender: str, message: Message) -> None:
        if not self._left:
            self._receive(sender, message)

    # --- on the simulation's loop ----------------------------------------------------------------

    def _join(self, network: Bus, agent: str, life: int) -> None:
        self._inner = network.join(agent, self._on_message, life)

    def _publish(self, key: str, message: Message) -> None:
        self._inner.publish(key, message)

    def _send(self, to: str, message: Message) -> None:
        self._inner.send(to, message)

    def _subscribe(self, key: str) -> None:
        self._inner.subscribe(key)

    def _unsubscribe(self, key: str) -> None:
        self._inner.unsubscribe(key)

    def _leave(self) -> None:
        self._inner.leave()

    def _on_message(self, sender: str, message: Message) -> None:
        self._out.say(message, self._arrive, sender, message)


class BridgedBus:
    """The simulated network as a `dray.ports.Bus` for agents on the outer loop.

    Args:
        network: the bus inside; used on the simulation's thread only.
        sim_loop: the loop of the simulation.
        outer_loop: the loop on which this bus is used and on which its agents receive.

    Attributes:
        inbound: the crossing to the simulation.
        outbound: the crossing to the outer loop.
    """

    def __init__(
        self, network: Bus, sim_loop: asyncio.AbstractEventLoop, outer_loop: asyncio.AbstractEventLoop
    ) -> None:
        self.network = network
        self.inbound = Crossing(sim_loop)
        self.outbound = Crossing(outer_loop)
        self._sessions: dict[str, BridgedSession] = {}
        """The latest session of every agent that ever joined from outside: a handful."""

    def join(self, agent: str, receive: Receive, life: int = 0) -> BridgedSession:
        """See `dray.ports.Bus.join`; the joining takes effect with the next turn of the simulation."""
        session = BridgedSession(self, agent, receive, life)
        before = self._sessions.get(agent)
        if before is None or before.life <= life:
            if before is not None:
                before.silence()
            self._sessions[agent] = session
        return session


class SimThread(Generic[T]):
    """A simulated factory in a thread of its own.

    Args:
        main: makes the coroutine that builds the factory and calls `ready` with anything that the outside needs (the
            network, say). The coroutine then runs the factory until it is cancelled.
        pace: `paced(speed)`.
        start_s: the first reading of the factory's clock.
        wall: by which it is paced; the computer's when None.

    Attributes:
        loop: the factory's loop; call into it by `call_soon_threadsafe` only.
        ended: done when the thread has ended; holds the factory's exception, if that was why.
    """

    def __init__(
        self,
        main: Callable[[Callable[[T], None]], Coroutine[Any, Any, None]],
        pace: Pace,
        start_s: float = 0.0,
        wall: Wall | None = None,
    ) -> None:
        wall = wall or steady_wall()
        self.loop = VirtualLoop(pace, start_s, selector=wall.selector, wall_s=wall.now_s)
        self.ended: Future[None] = Future()
        self._main = main
        self._ready: Future[T] = Future()
        self._task: asyncio.Task[None] | None = None
        self._stopping = False
        # A daemon, so that a factory that does not stop cannot keep the whole process from ending.
        self._thread = threading.Thread(target=self._run, name="dray-sim", daemon=True)

    def start(self, timeout_s: float | None = None) -> T:
        """Start the thread and wait until the factory is ready.

        Returns:
            The argument with which the factory has called `ready`.

        Raises:
            TimeoutError: not ready after `timeout_s` real seconds; it goes on trying.
            Exception: that of the factory before it was ready.
        """
        prepare_shapes()
        self._thread.start()
        return self._ready.result(timeout_s)

    async def wait(self) -> None:
        """Wait on the outer loop until the factory has ended.

        Raises:
            Exception: the cause of the factory's end, when it was not `stop`.
        """
        await asyncio.shield(asyncio.wrap_future(self.ended))

    def stop(self, timeout_s: float = STOP_S) -> None:
        """Cancel the factory and wait for the end of the thread. Twice is harmless.

        Raises:
            UnavailableError: it has not stopped after `timeout_s` real seconds.
            Exception: the cause of an earlier end of the factory.
        """
        self._stopping = True
        if self._thread.ident is None:
            self.loop.close()
            return
        with contextlib.suppress(RuntimeError):  # the loop is closed: it has ended by itself
            self.loop.call_soon_threadsafe(self._cancel)
        self._thread.join(timeout_s)
        if self._thread.is_alive():
            raise UnavailableError(
                "the simulated factory", f"has not stopped within {timeout_s} s", "end the process"
            )
        self.ended.result()

    # --- on the simulation's thread --------------------------------------------------------------

    def _run(self) -> None:
        error: BaseException | None = None
        try:
            with asyncio.Runner(loop_factory=lambda: self.loop) as runner:
                runner.run(self._live())
        except BaseException as caught:  # noqa: BLE001 (handed on to the waiters)
            # A cancellation that was asked for is no error.
            error = None if self._stopping and isinstance(caught, asyncio.CancelledError) else caught
        if not self._ready.done():
            self._ready.set_exception(
                error
                or UnavailableError("the simulated factory", "ended before it was ready", "start it again")
            )
        if error is None:
            self.ended.set_result(None)
        else:
            self.ended.set_exception(error)

    async def _live(self) -> None:
        self._task = asyncio.current_task()
        if not self._stopping:
            await self._main(self._ready.set_result)

    def _cancel(self) -> None:
        if self._task is not None:
            self._task.cancel()
