"""The load on board: the master's own knowledge, since many vehicles do not report it, and its comparison with their reports."""

from __future__ import annotations

from dray.adapters.vda5050.profile import Profile
from dray.adapters.vda5050.wire.messages import Load, State

DIFFERS_S = 3.0
"""Maximum delay of a load sensor after the end of a pick."""


class OnBoard:
    """The load of one vehicle.

    Args:
        profile: the meaning of its `loads`.
        item: the last life's item; empty for nothing.
        quantity: pieces of it.
        doubt: why the load is unknown.

    Attributes:
        doubt: why the load is unknown: the end of a pick or drop was not seen. A person resolves it: a vehicle that returns from
            another mode to AUTOMATIC has been checked.
        difference: how the vehicle's report differs; empty when it does not.
        flickers: whether the report differed only for a moment, without an action that had just ended.
    """

    def __init__(self, profile: Profile, item: str, quantity: int, doubt: str) -> None:
        self._profile = profile
        self.item, self.quantity = item, quantity
        self.doubt = doubt
        self.difference = ""
        self.flickers = False
        self._is_settled = False
        """Whether the report has agreed since the last pick or drop."""
        self._differs_s: float | None = None
        self._open: tuple[str, int] = ("", 0)
        """The load of a pick whose end was not seen."""

    def picked(self, item: str, quantity: int) -> None:
        """A load is on board."""
        self.item, self.quantity, self._differs_s, self.difference = item, quantity, None, ""
        self._is_settled = False

    def dropped(self) -> None:
        """The load is not on board any more."""
        self.picked("", 0)

    def lose_track(self, what: str, item: str, quantity: int, state: State) -> None:
        """The end of a pick or drop was not seen: use the vehicle's report, or ask people where it has none.

        Args:
            what: pick or drop.
            item: its item.
            quantity: pieces of it.
            state: the newest state.
        """
        told = self._told(state)
        if told is None:
            self._open = (item, quantity) if what == "pick" else ("", 0)
            self.doubt = (
                f"nobody saw the end of its {what}: see what is on board, and switch it to MANUAL and back"
            )
        elif told:
            self.picked(item, quantity)
        else:
            self.dropped()

    def on_state(self, state: State, *, is_handling: bool, now_s: float) -> bool:
        """Compare with the vehicle's report.

        Args:
            state: the newest state.
            is_handling: whether a pick or drop is under way.
            now_s: the present time.

        Returns:
            Whether the known load has changed.
        """
        self.flickers = False
        told = self._told(state)
        if told is None or is_handling:
            self._differs_s, self.difference = None, ""
            return False
        if self.doubt:
            item, quantity = (self.item, self.quantity) if self.item else self._open
            self.picked(item, quantity) if told and item else self.dropped()
            self.doubt = ""
            return True
        if self._agrees(told):
            self.flickers = self._is_settled and self._differs_s is not None and not self.difference
            self._differs_s, self.difference, self._is_settled = None, "", True
            return False
        self._differs_s = now_s if self._differs_s is None else self._differs_s
        if now_s - self._differs_s >= DIFFERS_S:
            ours = f"{self.quantity} {self.item}" if self.item else "nothing"
            theirs = ", ".join(load.load_type or "a load" for load in told) or "nothing"
            self.difference = (
                f"tells that {theirs} is on board, and {ours} should be: see to it, then MANUAL and back"
            )
        return False

    def was_attended(self, state: State) -> None:
        """People have checked the vehicle: its report counts; without one, an unseen action had no effect."""
        told = self._told(state)
        if self.difference and told == ():
            self.dropped()
        if self.difference and told and told[0].load_type and self._profile.load == "type":
            self.picked(told[0].load_type, self.quantity or 1)
        self.doubt = ""

    def _told(self, state: State) -> tuple[Load, ...] | None:
        return None if self._profile.load == "none" else state.loads

    def _agrees(self, told: tuple[Load, ...]) -> bool:
        if bool(told) != bool(self.item):
            return False
        if self._profile.load != "type" or not told or told[0].load_type is None:
            return True
        return told[0].load_type == self.item
