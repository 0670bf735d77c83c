"""The network of the simulated factory: a `dray.ports.Bus` in one process, on virtual time.

Every delivery to every receiver is an event of its own on the clock, after a delay of its own. Chance comes only from
the generators that are handed in, and receivers are served in the order in which they joined. So one seed gives one
run.

This module decides which way a message goes. Without faults there is one way, the WLAN. Another is looked for while a
fault is active or a vehicle could be without WLAN (`_publish_ill`, `_send_ill`). A run without faults pays for faults
with one question per utterance. `dray_sim.network.wlan` and `dray_sim.network.radio` apply delays and losses.

    sender --WLAN--> receiver                                    all is well, or the link has troubles
    vehicle --radio--> vehicles ... gateway --WLAN--> receiver   the sender has no WLAN: a frame rises
    sender --WLAN--> gateway --radio--> vehicles ... vehicle     the receiver has none: a frame falls

Only vehicles have a radio (`equip`); all others are wired. A frame falls the way on which the last
frame of its receiver rose.
"""

from __future__ import annotations

from collections import Counter
from random import Random
from typing import TYPE_CHECKING

from msgspec.structs import replace

from dray.codec import decode, encode
from dray.messages import AtvHeartbeat, HelpCall, Link, ShutOut
from dray.messages.speakers import objection
from dray_sim.network.coverage import Coverage
from dray_sim.network.latency import WLAN, Latency
from dray_sim.network.links import Links
from dray_sim.network.modem import Modem, Modems, Notice
from dray_sim.network.radio import RADIO, UNFIT, Frame, Radio, RadioSpec
from dray_sim.network.session import SimSession
from dray_sim.network.subscriptions import Subscriptions
from dray_sim.network.wlan import Wlan

if TYPE_CHECKING:
    from collections.abc import Callable

    from dray.messages import Message, Pose
    from dray.messages.kinds import Kind
    from dray.ports import Receive
    from dray_sim.clock.loop import VirtualClock
    from dray_sim.network.faults import NetworkFault
    from dray_sim.network.listeners import Listener

GATEWAY_S = 12.0
"""Time for which a vehicle is reached over its last gateway: two heartbeats of an idle vehicle and a little more."""

NO_WLAN = "no WLAN"
NO_GATEWAY = "no way by radio"


class SimNetwork:
    """The simulated agents' bus (see `dray.ports.Bus`).

    Args:
        clock: deliveries are its callbacks.
        random: the only source of chance for delays.
        latency: how long messages are under way.
        codec: pass every message through the wire format. Slower, and the trace is the same.
        trace: a `Trace` or another listener; hears every utterance, whether or not anybody else does. A vehicle's
            message by radio is heard when it is sent. A heartbeat is heard once more when a gateway puts it on the
            bus, with the gateway as its sender and with its relays.
        chance: the only source of chance for faults and the radio.
        coverage: of the WLAN while nothing is wrong.
        radio: the properties of vehicles' radios.

    Attributes:
        delivered: messages that reached an agent.
        missed: messages without a receiver or from an absent sender: the agent is not, or no longer, there.
        lost: messages that faults and the radio have lost, by reason; reasons are few and fixed. A publication whose
            sender is without WLAN counts once, every other loss once for each receiver.
        refused: messages that were dropped because their sender may not send them, by reason
            (`dray.messages.speakers`).
        kinds: kinds of the plant's agents; unknown for others.
        shut_out: agents whose messages are dropped; replaced as a whole.
        relayed: frames that a gateway has put on the bus.
        wlan: its deliveries.
        radio: the vehicles' radios.
    """

    def __init__(
        self,
        clock: VirtualClock,
        random: Random,
        latency: Latency = WLAN,
        *,
        codec: bool = False,
        trace: Listener | None = None,
        chance: Random | None = None,
        coverage: Coverage | None = None,
        radio: RadioSpec = RADIO,
    ) -> None:
        self.delivered = 0
        self.missed = 0
        self.lost: Counter[str] = Counter()
        self.refused: Counter[str] = Counter()
        self.kinds: dict[str, Kind] = {}
        self.shut_out: frozenset[str] = frozenset()
        self._decision = 0
        """Number of the newest decision about excluded agents."""
        self.relayed = 0
        self._clock = clock
        self._codec = codec
        self._trace = trace
        self._joins = 0
        self._sessions: dict[str, SimSession] = {}
        self._thieves: dict[str, SimSession] = {}
        """Thief by the agent whose certificate it has stolen."""
        self._subscriptions = Subscriptions()
        # Faults have a generator of their own, so that a fault does not shift other chances.
        chance = chance if chance is not None else Random("network faults")
        self._links = Links(coverage if coverage is not None else Coverage())
        self._modems = Modems(clock, self._links)
        self.wlan = Wlan(clock, random, latency, links=self._links, chance=chance, lost=self.lost)
        self.radio = Radio(
            clock,
            chance,
            radio,
            stations=self._modems.stations,
            on_air=self._on_air,
            take=self._take_frame,
            lost=self.lost,
        )

    # --- the port --------------------------------------------------------------------------------

    def join(self, agent: str, receive: Receive, life: int = 0) -> SimSession:
        """See `dray.ports.Bus.join`."""
        before = self._sessions.get(agent)
        self._joins += 1
        session = SimSession(self, self._joins, agent, receive, life)
        if before is not None and before.life > life:
            session.joined = False
            return session
        if before is not None:
            self.leave(before)
        self._sessions[agent] = session
        return session

    # --- what can go wrong -----------------------------------------------------------------------

    def steal(self, agent: str, receive: Receive) -> SimSession:
        """Join under the name of an agent that is there and stays, like a thief of its certificate.

        The thief also hears messages to the agent alone, and the agent's messages to others. It can open everything
        that is sealed with the certificate.
        """
        self._joins += 1
        session = self._thieves[agent] = SimSession(self, self._joins, agent, receive, 0)
        return session

    def equip(self, agent: str, where: Callable[[], Pose], notice: Notice) -> None:
        """Give a vehicle its modem. An agent without a modem is wired. Again for the same agent: a new modem.

        Args:
            agent: the vehicle's agent; it need not have joined.
            where: its pose at this moment.
            notice: told when its modem has lost the WLAN for a while, or has had it again for as long.
        """
        self._modems.equip(Modem(agent, where, notice))

    @property
    def access_points(self) -> tuple[str, ...]:
        """The ids of all access points, up or down."""
        return self._links.access_points

    def cover(self, coverage: Coverage) -> None:
        """Replace the coverage that there is while nothing is wrong."""
        self._links.cover(coverage)
        self._modems.look_around()

    def begin(self, fault: NetworkFault) -> None:
        """Begin a fault now. The same fault begun twice must end twice."""
        self._links.begin(fault)
        self._modems.look_around()

    def end(self, fault: NetworkFault) -> None:
        """End a fault.

        Raises:
            ValueError: this fault is not active.
        """
        self._links.end(fault)
        self._modems.look_around()

    def plug_in(self, agent: str) -> bool:
        """A person has repaired an agent's own WLAN; returns whether it was cut."""
        mended = self._links.plug_in(agent)
        self._modems.look_around()
        return mended

    def link_of(self, agent: str) -> Link:
        """The link in use by an agent's modem; wired agents have only WLAN."""
        modem = self._modems.stations.get(agent)
        return Link.WLAN if modem is None else modem.link

    # --- what sessions ask -----------------------------------------------------------------------

    def publish(self, sender: SimSession, key: str, message: Message) -> None:
        """Carry `message` to all that listen on `key`."""
        if not self._may_say(sender, key, message):
            return
        if type(message) is ShutOut:
            self._shut_out(message)
        message = self._utter(sender.agent, key, message)
        receivers = self._subscriptions.found.get(key)
        if receivers is None:
            receivers = self._subscriptions.of(key)
        if self._modems.busy:
            self._publish_ill(sender, key, message, receivers)
            return
        carry = self.wlan.carry
        for receiver in receivers:
            carry(sender, receiver, message)

    def send(self, sender: SimSession, to: str, message: Message) -> None:
        """Carry `message` to one agent."""
        if not self._may_say(sender, "", message):
            return
        message = self._utter(sender.agent, f">{to}", message)
        receiver = self._sessions.get(to)
        if receiver is None:
            self.missed += 1
            return
        if self._modems.busy:
            self._send_ill(sender, receiver, message)
        else:
            self.wlan.carry(sender, receiver, message)
        for thief in self._thieves.values():
            if thief is not sender and thief.agent in (to, sender.agent):
                self.wlan.carry(sender, thief, message)

    def subscribe(self, session: SimSession, key: str) -> None:
        """Let `session` hear `key`, which may hold wildcards."""
        self._subscriptions.add(session, key)

    def unsubscribe(self, session: SimSession, key: str) -> None:
        """Let `session` hear `key` no longer."""
        self._subscriptions.remove(session, key)

    def leave(self, session: SimSession) -> None:
        """Forget `session`; messages under way to it are dropped when they arrive."""
        session.joined = False
        for there in (self._sessions, self._thieves):
            if there.get(session.agent) is session:
                del there[session.agent]
        self._subscriptions.forget(session)

    # --- the way of a message --------------------------------------------------------------------

    def _may_say(self, sender: SimSession, key: str, message: Message) -> bool:
        """Whether it goes on its way; counted if not. `key` is empty for a message to one agent alone."""
        if not sender.joined:
            self.missed += 1
            return False
        agent = sender.agent
        reason = objection(agent, self.kinds.get(agent), key, message, self.shut_out)
        if reason:
            self.refused[reason] += 1
        return not reason

    def _shut_out(self, said: ShutOut) -> None:
        """Drop all messages of these agents from now on, all at once: on the real bus each process is told separately."""
        if said.number > self._decision:
            self._decision, self.shut_out = said.number, frozenset(said.agents)

    def _utter(self, sender: str, address: str, message: Message) -> Message:
        if self._trace is not None:
            self._trace.on_message(self._clock.time_s, sender, address, message)
        return decode(encode(sender, message))[1] if self._codec else message

    # --- the way of a message while something is wrong -------------------------------------------

    def _publish_ill(
        self, sender: SimSession, key: str, message: Message, receivers: tuple[SimSession, ...]
    ) -> None:
        if not self._modems.talks_wlan(sender.agent):
            if sender in receivers:
                self.wlan.carry(sender, sender, message)
            if type(message) in (AtvHeartbeat, HelpCall):
                self._rise(Frame(sender.agent, message, key=key))
            else:
                self._lose_unsaid(sender.agent)
            return
        for receiver in receivers:
            self._carry_ill(sender.agent, sender.agent, receiver, message, sender.context)

    def _send_ill(self, sender: SimSession, receiver: SimSession, message: Message) -> None:
        if receiver is sender:
            self.wlan.carry(sender, receiver, message)
        elif not self._modems.talks_wlan(sender.agent):
            self._rise(Frame(sender.agent, message, to=receiver.agent))
        elif self._modems.has_wlan(receiver.agent):
            self._carry_ill(sender.agent, sender.agent, receiver, message, sender.context)
        else:
            self._hand_down(sender.agent, Frame(sender.agent, message, to=receiver.agent))

    def _carry_ill(
        self, over: str, sender: str, receiver: SimSession, message: Message, context: str = ""
    ) -> None:
        """Decide the fate of one delivery on the WLAN, sent by `over` for `sender`."""
        if receiver.agent != over and not self._modems.has_wlan(receiver.agent):
            self.lost[NO_WLAN] += 1
        elif context:
            self.wlan.pass_link(over, receiver.agent, receiver.deliver_with, context, sender, message)
        else:
            self.wlan.pass_link(over, receiver.agent, receiver.deliver, sender, message)

    # --- the radio -------------------------------------------------------------------------------

    def _rise(self, frame: Frame) -> None:
        """Send a message of a vehicle without WLAN by radio; a modem that has not noticed the loss yet tries WLAN."""
        modem = self._modems.stations.get(frame.origin)
        if modem is None or modem.link is Link.WLAN:
            self.lost[NO_WLAN] += 1
            return
        if not self._on_air(frame.origin):
            self.lost[NO_GATEWAY] += 1
            return
        short = self.radio.shorten(frame.origin, frame.message)
        if short is not None:
            frame.message = short
            self.radio.send(modem, frame)

    def _lose_unsaid(self, sender: str) -> None:
        """Count a publication that a vehicle without WLAN cannot make."""
        by_radio = self.link_of(sender) is Link.MESH
        self.lost[UNFIT if by_radio else NO_WLAN] += 1

    def _hand_down(self, start: str, frame: Frame) -> None:
        """Send from `start`, which has WLAN, to a vehicle without: by WLAN to its gateway, then by radio."""
        modem = self._modems.stations.get(frame.to)
        if modem is None:
            self.lost[NO_WLAN] += 1
            return
        short = self.radio.shorten(frame.origin, frame.message)
        if short is None:
            return
        gateway = self._sessions.get(modem.gateway)
        if gateway is None or self._clock.time_s > modem.gateway_s + GATEWAY_S:
            self.lost[NO_GATEWAY] += 1
            return
        falling = Frame(frame.origin, short, to=frame.to, rising=False, reached=frame.reached)
        self.wlan.pass_link(start, gateway.agent, self._fall, gateway.agent, falling)

    def _fall(self, gateway: str, frame: Frame) -> None:
        """A frame for a vehicle without WLAN has come to the gateway that is to say it by radio."""
        if self._on_air(gateway) and self._modems.has_wlan(gateway):
            self.radio.send(self._modems.stations[gateway], frame)
        else:
            self.lost[NO_GATEWAY] += 1

    def _take_frame(self, station: Modem, frame: Frame, via: tuple[str, ...]) -> bool:
        """Decide how a vehicle handles a frame; true when it should send it again (see `Radio`)."""
        session = self._sessions[station.agent]
        if frame.to == station.agent:
            self._reach(session, frame)
            return False
        if (
            frame.key
            and not self._modems.has_wlan(station.agent)
            and session in self._subscriptions.of(frame.key)
        ):
            session.deliver(frame.origin, _came_over(frame.message, via))
        if frame.rising and station.link is Link.WLAN:
            self._put_on_bus(session, frame, via)
            return False
        return True

    def _put_on_bus(self, gateway: SimSession, frame: Frame, via: tuple[str, ...]) -> None:
        if not self._modems.talks_wlan(gateway.agent):
            self.lost[NO_WLAN] += 1
            return
        # A gateway that hears on the bus that another one was first drops its copy.
        apart = (self._links.troubles(other, gateway.agent) is None for other in frame.gateways)
        if not all(apart):
            return
        frame.gateways.append(gateway.agent)
        self.relayed += 1
        origin = self._modems.stations[frame.origin]
        origin.gateway, origin.gateway_s = gateway.agent, self._clock.time_s
        if frame.key:
            message = _came_over(frame.message, (*via, gateway.agent))
            message = self._utter(gateway.agent, frame.key, message)
            for receiver in self._subscriptions.of(frame.key):
                if receiver.agent != frame.origin:
                    self._carry_ill(gateway.agent, frame.origin, receiver, message)
            return
        addressee = self._sessions.get(frame.to)
        if addressee is None:
            self.missed += 1
        elif self._modems.has_wlan(frame.to):
            self.wlan.pass_link(gateway.agent, frame.to, self._reach, addressee, frame)
        else:
            self._hand_down(gateway.agent, frame)

    def _reach(self, receiver: SimSession, frame: Frame) -> None:
        """A frame has come to the one agent that it is for: the first of its ways counts."""
        if not frame.reached:
            frame.reached.append(receiver.agent)
            receiver.deliver(frame.origin, frame.message)

    def _on_air(self, agent: str) -> bool:
        """Whether a vehicle's radio works: it has power, a process, and no fault in the radio itself."""
        return agent in self._sessions and agent not in self._links.radio_cut


def _came_over(message: Message, via: tuple[str, ...]) -> Message:
    """A heartbeat marked with the vehicles that passed it on."""
    return replace(message, via=via) if type(message) is AtvHeartbeat else message
