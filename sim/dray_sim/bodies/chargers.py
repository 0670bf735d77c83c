"""Which charger feeds which vehicle: one at a time (`dray.plant.model.Charger`)."""

from __future__ import annotations


class Chargers:
    """The plugs of all chargers of a plant. A vehicle stays plugged in until it drives away."""

    def __init__(self) -> None:
        self._plugged: dict[str, str] = {}

    def plug(self, charger: str, vehicle: str) -> str:
        """Connect a vehicle; harmless when it is connected already.

        Returns:
            "" when it is connected now, else the reason, which names the other vehicle.
        """
        occupant = self._plugged.setdefault(charger, vehicle)
        return "" if occupant == vehicle else f"occupied by {occupant}"

    def unplug(self, charger: str, vehicle: str) -> None:
        """Disconnect a vehicle; harmless when it is not connected."""
        if self._plugged.get(charger) == vehicle:
            del self._plugged[charger]

    def occupant(self, charger: str) -> str:
        """The vehicle that is plugged in; empty for none."""
        return self._plugged.get(charger, "")
