"""A vehicle's actions at a stand (loading, unloading, charging), and its load.

Like its counterpart `dray_sim.bodies.vehicle.travel` it has no clock of its own. The vehicle tells it how much time
has passed, and calls `finish` when the manoeuvre ends; the result of an action is reported here. The vehicle accounts
for the battery.
"""

from __future__ import annotations

from dray.body import ActionDone, ActionFailed, Charge, Drop, Pick
from dray.plant import Plant
from dray.plant.model import VehicleType
from dray_sim.bodies.durations import Durations
from dray_sim.bodies.reporter import Reporter
from dray_sim.bodies.stands import Stands

Action = Pick | Drop | Charge


class Handling:
    """The action of one vehicle, and its load.

    Invariants: one action at a time; only a place or a person that gives or receives pieces changes the load.

    Args:
        vehicle: its id.
        vehicle_type: its load capacity and its handling times.
        plant: items, stations and chargers.
        stands: where it can load, unload and charge.
        reporter: the vehicle's reports.
        seed: how long each manoeuvre takes follows from it, where that varies.

    Attributes:
        action: under way; None for none.
        left_s: how long a pick or drop still takes, as of the last `spend`; nothing that holds for a charge.
        load: the item on board; empty for none.
        quantity: pieces of it.
    """

    def __init__(
        self,
        vehicle: str,
        vehicle_type: VehicleType,
        plant: Plant,
        stands: Stands,
        reporter: Reporter,
        seed: int,
    ) -> None:
        self.action: Action | None = None
        self.left_s = 0.0
        self.load = ""
        self.quantity = 0
        self._vehicle = vehicle
        self._type = vehicle_type
        self._plant = plant
        self._stands = stands
        self._reporter = reporter
        self._durations = Durations(f"{seed} handling {vehicle}")
        self._charger = ""
        """The charger where it is plugged in."""

    def start_action(self, action: Action, node: str) -> str:
        """Begin an action.

        Args:
            action: to begin.
            node: where the vehicle stands.

        Returns:
            "" when it has begun, else why it cannot.
        """
        reason = self._refusal(action, node)
        if reason:
            return reason
        self.action = action
        if isinstance(action, Charge):
            self._charger = action.charger
        else:
            mean_s = self._type.load_s if isinstance(action, Pick) else self._type.unload_s
            self.left_s = self._durations.draw_s(mean_s, self._plant.handling_cv(action.station, self._type))
        return ""

    def spend(self, seconds: float) -> None:
        """Work for so long."""
        if self.action is not None:
            self.left_s = max(self.left_s - seconds, 0.0)

    def finish(self, action: Action) -> None:
        """The manoeuvre has come to its end: the load changes hands, or the battery is full."""
        reason = "" if isinstance(action, Charge) else self._transfer(action)
        if reason:
            self.abort(reason)
        else:
            self.finish_action()
            self._reporter.say(ActionDone(order=action.order))

    def follow(self, action: Pick | Drop) -> str:
        """Repeat the pick or drop of the vehicle whose double this is; returns why the load cannot change hands here."""
        if action.station not in self._stands.places:
            return f"no station {action.station}"
        if isinstance(action, Drop):
            return self._transfer(action) if self.load else "nothing on board"
        return f"{self.load} is on board" if self.load else self._transfer(action)

    def abort(self, reason: str) -> None:
        """End the action, if any, without effect; a charge has had its effect and ends without a word."""
        if self.action is not None and not isinstance(self.action, Charge):
            self._reporter.say(ActionFailed(order=self.action.order, reason=reason))
        self.finish_action()

    def _transfer(self, action: Pick | Drop) -> str:
        """Let the load change hands, at once and wholly; returns why it cannot."""
        place = self._stands.places[action.station]
        if isinstance(action, Drop):
            reason = place.put(self._vehicle, self.load, self.quantity, action.goal)
            if not reason:
                self.load, self.quantity = "", 0
            return reason
        reason = place.take(self._vehicle, action.item, action.quantity)
        if not reason:
            self.load, self.quantity = action.item, action.quantity
        return reason

    def finish_action(self) -> None:
        """End the action with any result; a plug stays in."""
        self.action = None

    def take_off(self) -> tuple[str, int]:
        """Somebody else takes the load. Returns the item and how many; `("", 0)` for nothing."""
        load = self.load, self.quantity
        self.load, self.quantity = "", 0
        return load

    def unplug(self) -> None:
        """Leave the charger; harmless at none."""
        self._stands.chargers.unplug(self._charger, self._vehicle)
        self._charger = ""

    def _refusal(self, action: Action, node: str) -> str:
        """Why an action cannot begin; empty when it can. A charge that can begin is plugged in by this call."""
        if self.action is not None:
            return "busy with another action"
        if isinstance(action, Charge):
            if action.charger not in self._plant.chargers:
                return f"no charger {action.charger}"
            if self._plant.node_of(action.charger) != node:
                return f"not at {action.charger}"
            return self._stands.chargers.plug(action.charger, self._vehicle)
        if action.station not in self._stands.places:
            return f"no station {action.station}"
        if self._stands.nodes[action.station] != node:
            return f"not at {action.station}"
        if isinstance(action, Drop):
            return "" if self.load else "nothing on board"
        return self._why_not_pick(action)

    def _why_not_pick(self, pick: Pick) -> str:
        """Why this vehicle can never pick this; empty when it can."""
        item = self._plant.materials.get(pick.item) or self._plant.products.get(pick.item)
        if self.load:
            return f"{self.load} is on board"
        if item is None:
            # The item may be newer than the plant file: the agent that hires vehicles knows its container.
            return "" if pick.quantity >= 1 else "nothing to pick"
        if item.ability not in self._type.abilities:
            return f"cannot carry {item.ability}"
        if not 1 <= pick.quantity <= item.lot:
            return f"{pick.quantity} is not within a lot of {item.lot}"
        return ""
