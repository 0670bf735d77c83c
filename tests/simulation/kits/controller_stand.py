"""A stand to try a simulated body's controller on: it is told something, time passes, and it says something."""

from __future__ import annotations

from typing import Generic, Protocol, TypeVar

from yard import Yard

from dray.adapters.signals.signal import Signal, Value


class Controller(Protocol):
    """What all controllers can be told."""

    def on_write(self, signal: Signal, value: Value) -> None: ...


C = TypeVar("C", bound=Controller)


class ControllerStand(Generic[C]):
    """A body with a controller, and what that has told. Who makes a stand adds the two.

    Attributes:
        yard: where the body stands.
        controller: the body's.
    """

    controller: C

    def __init__(self) -> None:
        self.yard = Yard()
        self._told: list[tuple[str, Value]] = []

    def on_told(self, signal: str, value: Value) -> None:
        """Give this to the controller: it tells what changes."""
        self._told.append((signal, value))

    def tell(self, **values: Value) -> None:
        """Tell the controller the values of its inputs, in this order."""
        for name, value in values.items():
            self.controller.on_write(Signal(name), value)

    def wait(self, for_s: float = 5.0) -> list[tuple[str, Value]]:
        """What is told meanwhile."""
        self._told.clear()
        self.yard.run(self.yard.clock.now_s() + for_s)
        return [*self._told]
