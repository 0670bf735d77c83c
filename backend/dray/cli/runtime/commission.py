"""The work of `dray vehicle` and `dray machine`: commissioning, and listening to a vehicle."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from dray.adapters.machine_acts import GateSpec, Spec
from dray.adapters.machine_acts import Wanted as Acting
from dray.adapters.mqtt.commissioning import MqttCommissioning
from dray.adapters.mqtt.mapping_file import MqttMapping
from dray.adapters.signals.signal import SignalMapping
from dray.adapters.vda5050.body import HEARD, VehicleBody
from dray.adapters.vda5050.commissioning import FIRST_STATE_S, Commissioning, Wanted
from dray.adapters.vda5050.control.master import MasterControl
from dray.adapters.vda5050.dialogue import Head, Recorder
from dray.adapters.vda5050.events import Heard, Linked, Memory, Say, Unlinked
from dray.adapters.vda5050.link import MqttLink
from dray.cli.runtime.bodies.broker import broker_of
from dray.cli.runtime.bodies.signals import RealController
from dray.cli.runtime.bodies.vda5050 import RealVehicle, linked
from dray.cli.runtime.output import one_of
from dray.cli.runtime.surroundings import Surroundings
from dray.errors import SettingsError
from dray.messages.keys import GATE
from dray.plant.model import VehicleType

if TYPE_CHECKING:
    from dray.adapters.opcua.commissioning import Commissioning as MachineCommissioning

SAID = ("order", "instantActions")

NAME = "check"
"""The commissioning agent's name, and the prefix of its orders."""


class _World:
    """A link and a log without a memory: a commissioning has only one life."""

    def __init__(self, link: MqttLink, say: Callable[[str], None]) -> None:
        self._link, self._say = link, say

    def publish(self, topic: str, data: bytes) -> None:
        self._link.publish(topic, data)

    def remember(self, memory: Memory) -> None:
        """Keep nothing: no later life follows."""

    def note(self, text: str) -> None:
        self._say(f"     {text}")


async def commission(
    where: Surroundings, kind: VehicleType, wanted: Wanted, record: Path | None, say: Callable[[str], None]
) -> Commissioning:
    """Run a vehicle's commissioning.

    Args:
        where: the surroundings; the settings name broker and vehicle.
        kind: its type in the plant.
        wanted: the extent.
        record: the file for the dialogue; None for none.
        say: tells people.

    Raises:
        SettingsError: something is missing, or unusable.
    """
    real = RealVehicle.of(where.settings)
    link = real.link(f"dray-{NAME}-{real.address.serial}")
    life = int(time.time())
    control = MasterControl(NAME, where.plant, kind, real.profile, life=life)
    clock = where.clock()
    body = VehicleBody(control, real.profile, real.address, clock, _World(link, say), where.time.to_wall_s)
    recorder = None
    if record is not None:
        recorder = Recorder(record, Head(NAME, where.plant.id, kind.id, real.profile, life))
        body.record = recorder.write
    done = Commissioning(body, where.plant, kind, real.profile, clock, wanted)
    say(
        f"{real.broker}: waits for the broker and for the first state of {real.address.serial}, "
        f"{FIRST_STATE_S:.0f} s each at most"
    )
    async with linked(link, body):
        async for step in done.run():
            say(step.line)
    if recorder is not None:
        recorder.close()
    return done


async def commission_machine(
    where: Surroundings, name: str, *, cycle: bool, dock: bool, say: Callable[[str], None]
) -> MachineCommissioning | MqttCommissioning:
    """Run the commissioning of the controller of a machine, of a storage's dock or of the gate.

    Args:
        where: the surroundings; the settings name the mapping.
        name: the id of a machine, a storage or a source warehouse; or the gate.
        cycle: whether it may make a piece.
        dock: whether it may open its dock.
        say: tells people.

    Raises:
        SettingsError: something is missing, or unusable.
    """
    plant = where.plant
    if (store := plant.stores.get(name)) is not None:
        if cycle:
            raise SettingsError("--cycle", f"{name} is a storage: it makes nothing")
        room = {line.material: line.capacity for line in store.stocks}
        controller = RealController.of(where.settings, lambda mapping: mapping.check_store(room))
    elif name == GATE:
        if cycle:
            raise SettingsError("--cycle", "the gate makes nothing")
        controller = RealController.of(where.settings, lambda mapping: mapping.check_gate())
    else:
        controller = RealController.of(where.settings, SignalMapping.check_machine)
    choices: dict[str, Spec] = {**plant.machines, **plant.stores, GATE: GateSpec()}
    spec = one_of(choices, name, "NAME")
    wanted, clock, mapping = Acting(cycle, dock), where.clock(), controller.mapping
    done: MachineCommissioning | MqttCommissioning
    if isinstance(mapping, MqttMapping):
        done = MqttCommissioning(mapping, broker_of(where.settings), spec, where.plant, clock, wanted)
    else:
        from dray.adapters.opcua.commissioning import Commissioning

        done = Commissioning(
            mapping, controller.folder, controller.password, spec, where.plant, clock, wanted
        )
    async for step in done.run():
        say(step.line)
    return done


async def listen(where: Surroundings, kind: VehicleType, file: Path, say: Callable[[str], None]) -> None:
    """Record the messages of a vehicle and its master, until cancelled.

    Raises:
        SettingsError: something is missing, or unusable.
    """
    real = RealVehicle.of(where.settings)
    prefix = real.profile.topic(real.address.manufacturer, real.address.serial, "").rstrip("/")
    link = MqttLink(real.broker, prefix, f"dray-record-{real.address.serial}", (*HEARD, *SAID))
    clock = where.clock()
    recorder = Recorder(file, Head(real.address.serial, where.plant.id, kind.id, real.profile))
    try:
        await link.run(_Ear(recorder, clock.now_s, say))
    except asyncio.CancelledError:
        say(f"written: {file}")
        raise
    finally:
        recorder.close()


class _Ear:
    """Listens to both sides."""

    def __init__(self, recorder: Recorder, now_s: Callable[[], float], say: Callable[[str], None]) -> None:
        self._recorder, self._now_s, self._say = recorder, now_s, say
        self._count = 0

    def on_link(self) -> None:
        self._say("the broker is there; Ctrl-C ends the record")
        self._recorder.write(self._now_s(), Linked())

    def on_link_lost(self, reason: str) -> None:
        self._say(f"the broker is away: {reason}")
        self._recorder.write(self._now_s(), Unlinked(reason))

    def on_message(self, topic: str, data: bytes) -> None:
        if topic == "order":
            self._recorder.write(self._now_s(), Say("order", {"text": data.decode("utf-8", "replace")}))
        elif topic == "instantActions":
            self._recorder.write(
                self._now_s(), Say("instantActions", {"text": data.decode("utf-8", "replace")})
            )
        else:
            self._recorder.write(self._now_s(), Heard(topic, data))
        self._count += 1
        if self._count == 1:
            self._say("the first message has come")
