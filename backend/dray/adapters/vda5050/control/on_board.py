"""What is on board: the master's own knowledge, since many vehicles do not tell, and its agreement with what they tell."""

from __future__ import annotations

from dray.adapters.vda5050.profile import Profile
from dray.adapters.vda5050.wire.messages import Load, State

DIFFERS_S = 3.0
"""A load sensor may lag behind the end of a pick by so much."""


class OnBoard:
    """The load of one vehicle.

    Args:
        profile: what its `loads` is good for.
        item: as the life before knew it; empty for nothing.
        quantity: pieces of it.
        doubt: why that is not known.

    Attributes:
        doubt: why it is not known what is on board: a pick or drop whose end nobody saw. A person sees to it: a vehicle that
            was in another mode than AUTOMATIC, and is back, has been looked after.
        difference: how what the vehicle tells differs; empty when it does not.
        flickers: what the vehicle told differed only for a moment, and no action had just ended.
    """

    def __init__(self, profile: Profile, item: str, quantity: int, doubt: str) -> None:
        self._profile = profile
        self.item, self.quantity = item, quantity
        self.doubt = doubt
        self.difference = ""
        self.flickers = False
        self._is_settled = False
        """What is told has agreed since the last pick or drop."""
        self._differs_s: float | None = None
        self._open: tuple[str, int] = ("", 0)
        """What a pick was about whose end nobody saw."""

    def picked(self, item: str, quantity: int) -> None:
        """It is on board."""
        self.item, self.quantity, self._differs_s, self.difference = item, quantity, None, ""
        self._is_settled = False

    def dropped(self) -> None:
        """It is not any more."""
        self.picked("", 0)

    def lose_track(self, what: str, item: str, quantity: int, state: State) -> None:
        """A pick or drop has ended unseen: the vehicle is asked, and where it cannot tell, people are.

        Args:
            what: pick or drop.
            item: what it was about.
            quantity: pieces of it.
            state: the newest one.
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
        """Compare with what the vehicle tells.

        Args:
            state: the newest one.
            is_handling: a pick or drop is under way.
            now_s: the present time.

        Returns:
            Whether the knowledge has changed.
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
        """People have seen to the vehicle: its word counts; without one, what was not seen to end had no effect."""
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
