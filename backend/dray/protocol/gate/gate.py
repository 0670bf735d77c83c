"""The gate of the delivery warehouses: it reports arrivals, enforces admissions, and lets one strategist hold each order.

Its body counts pieces by goal, admits no more than allowed, and goes on while its agent is down; so no goods wait
for a process. The agent adds what a strategist relies on:

- every piece is reported once: counts are totals, stored before they are sent, and repeated until they are acknowledged;
  pieces that came while the agent was down are counted when it is back;
- only the strategist that holds an order admits its goals, and an old message about a goal changes nothing;
- an order is held by one strategist, with an epoch, over all lives of the gate.

If its body is people, it passes on their reports, with a grant for the area of a delivery warehouse.
If goods wait before its body (`GateState.late`) they count late, as with people. A body with a problem keeps the agent: what it admits and
what has arrived is told as ever, and its heartbeats give the reason.

It coordinates no transport. Pieces of a shut goal stay with their carrier.
"""

from __future__ import annotations

from itertools import islice

from msgspec import UNSET
from msgspec.structs import replace

from dray.body import Admit, BodyState, GateProblem, GateState, GoodsArrived, WordTaken
from dray.errors import ProtocolViolation
from dray.memory import WHOLE, GateGoal, GateMemory, Memory, Note
from dray.messages import (
    AdmissionAsked,
    CommandRefusal,
    CountAcknowledged,
    GateAsked,
    GateReported,
    GoodsCounted,
    Grant,
    HolderAcknowledged,
    HolderReported,
    MachineCommand,
    OrderClaimed,
    PeopleAsBody,
    StationHeartbeat,
)
from dray.messages.heartbeat import GOALS_TOLD, GoalToCome
from dray.messages.keys import GATE, Keys
from dray.messages.overtaken import LatestNumbers
from dray.plant import Plant
from dray.protocol.gate.admissions import KEPT_GOALS, Admissions
from dray.protocol.gate.order_holders import OrderHolders
from dray.protocol.liveness.suspicion import IDLE_INTERVAL_S
from dray.protocol.people.command_authorisation import CommandAuthorisation
from dray.protocol.people.granted_commands import GrantedCommands
from dray.protocol.people.words import PassedWords
from dray.protocol.runtime.agent import AgentBase
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.events import Send
from dray.protocol.runtime.life import BEAT
from dray.protocol.runtime.retransmission import Retransmitter
from dray.protocol.runtime.shutdown import COORDINATOR_LEAVES_WITHIN_S
from dray.protocol.runtime.trust import Trusts, trusts_nobody

COUNT, HOLDER = "count", "holder"
"""Alarms of a repeated count, by goal, and of a lost order, by order."""

NO_PEOPLE = "its controller counts, and nobody else"
"""Explanation of a refusal, for people."""


class DeliveryGate(AgentBase):
    """The agent of one plant's gate.

    Args:
        plant: the plant.
        agent: its id.
        incarnation: how often it has been started.
        software: the version it runs, for its heartbeat.
        kept: maximum number of remembered goals.
        trusts: the trusted signers of people's reports of arrivals.
    """

    def __init__(
        self,
        plant: Plant,
        *,
        agent: str = GATE,
        incarnation: int = 1,
        software: str = "",
        kept: int = KEPT_GOALS,
        trusts: Trusts = trusts_nobody,
    ) -> None:
        super().__init__(agent, incarnation, leaves_within_s=COORDINATOR_LEAVES_WITHIN_S)
        self._software = software
        self._beat_key = Keys(plant.id).station_heartbeat(agent)
        self._since = incarnation
        self._goals = Admissions(kept)
        self._orders = OrderHolders(self._goals)
        self._newest: LatestNumbers[str] = LatestNumbers(kept)
        """By goal: its newest request in this life."""
        self._begun_s = 0.0
        """When this life began."""
        self._obeyed: BoundedMap[str, int] = BoundedMap(kept)
        """By goal: the quantity that the body has confirmed to admit in this life."""
        self._counts = Retransmitter(COUNT, self._life)
        self._holders = Retransmitter(HOLDER, self._life)
        self._places_m = tuple(plant.position_of(each) for each in plant.delivery_warehouses)
        self._people = self._late = False
        self._problem = ""
        granted = GrantedCommands[MachineCommand](
            CommandAuthorisation(agent, plant, trusts), _refuse, _detail, self._life
        )
        self._granted, self._words = granted, PassedWords(granted, self._life)
        self._committers += [self._goals.commits, self._orders.commits]
        self._message_handlers = {
            GateAsked: self._on_gate_asked,
            AdmissionAsked: self._on_admission,
            CountAcknowledged: self._on_count_acknowledged,
            OrderClaimed: self._on_claimed,
            HolderAcknowledged: self._on_holder_acknowledged,
            MachineCommand: self._on_command,
        }
        self._report_handlers = {
            GoodsArrived: self._on_arrived,
            GateProblem: self._on_problem,
            WordTaken: self._word_taken,
        }
        self._alarm_handlers = {BEAT: self._beat, COUNT: self._counts.wake, HOLDER: self._holders.wake}

    # --- the beginning, time passing, and the end ---

    def _start(self, body: BodyState | None, memory: Memory, now_s: float) -> None:
        if not isinstance(body, GateState):
            raise ProtocolViolation(f"{self.id}: the delivery gate needs a gate, not {body!r}")
        self._begun_s = now_s
        self._people, self._late = body.people, body.people or body.late
        self._problem = body.problem
        note = memory.get(WHOLE)
        if isinstance(note, GateMemory):
            self._since = note.since
        else:
            self._life.commit()
        self._goals.restore(memory)
        self._orders.restore(memory)
        for goal in self._goals:
            self._take_up(goal, body.arrived, now_s)
        for order in self._orders.lost():
            self._say_lost(order.order, order.lost_by, now_s)
        self._life.beat_soon(now_s)

    def _take_up(self, goal: GateGoal, arrived: dict[str, int], now_s: float) -> None:
        """Count what came while the agent was down, and repeat to the body what it may have missed."""
        if arrived.get(goal.goal, 0) > goal.arrived:
            goal = self._count(goal, arrived[goal.goal], "")
        if goal.arrived < goal.admitted:
            # A controller without its count would admit the pieces again; a gate of people is told the count.
            if goal.goal in arrived or not goal.arrived or self._people:
                self._admit(goal)
        elif not goal.admitted:
            self._admit(goal)
        if goal.arrived > goal.heard:
            self._tell(goal, goal.admitted or goal.arrived, now_s)

    def _memory(self) -> Note:
        return GateMemory(self._since)

    def _beat(self, _about: None, now_s: float) -> None:
        self._say_status(now_s)
        self._life.beat_again(IDLE_INTERVAL_S, now_s)

    def _say_status(self, now_s: float) -> None:
        said = StationHeartbeat(
            station=self.id,
            incarnation=self.incarnation,
            seq=self._life.count_beat(),
            at_s=now_s,
            software=self._software,
            draining=self._shutdown.begun,
            people=PeopleAsBody(goals=self._to_come()) if self._people else UNSET,
            problem=self._problem,
        )
        self._life.publish(self._beat_key, said)

    def _take_leave(self, now_s: float) -> None:
        self._say_status(now_s)

    def _to_come(self) -> tuple[GoalToCome, ...]:
        short = (goal for goal in self._goals if goal.arrived < goal.admitted)
        return tuple(
            GoalToCome(goal.goal, goal.admitted - goal.arrived) for goal in islice(short, GOALS_TOLD)
        )

    # --- people ---

    def _on_command(self, sender: str, command: MachineCommand, now_s: float) -> None:
        if command.kind.is_word and self._people:
            self._words.pass_on(sender, command, self._places_m, now_s)
        else:
            self._granted.on_command(sender, command, self._places_m[0], now_s)

    def _word_taken(self, report: WordTaken, _now_s: float) -> None:
        self._words.on_taken(report)

    # --- goods ---

    def _on_arrived(self, report: GoodsArrived, now_s: float) -> None:
        """Goods have arrived, or the body has confirmed an admission."""
        goal = self._goals.get(report.goal)
        if goal is None:
            self._life.ignore("goods for an unknown goal")
            return
        self._obeyed[goal.goal] = report.admitted
        if report.arrived > goal.arrived:
            goal = self._count(goal, report.arrived, report.vehicle)
        if self._people:
            self._life.beat_soon(now_s)
        self._tell(goal, report.admitted, now_s)

    def _on_problem(self, report: GateProblem, now_s: float) -> None:
        """Tell at once that there is one, or none any more; a new reason with the next heartbeat."""
        is_news = bool(report.problem) is not bool(self._problem)
        self._problem = report.problem
        if is_news:
            self._life.beat_soon(now_s)

    def _count(self, goal: GateGoal, arrived: int, vehicle: str) -> GateGoal:
        if goal.of is not None:
            self._orders.count(goal.of.order, goal.of.item, arrived - goal.arrived)
        return self._goals.count(goal, arrived, vehicle)

    def _tell(self, goal: GateGoal, admitted: int, now_s: float) -> None:
        """Report the count of a goal to its strategist; an unacknowledged count is repeated."""
        obeyed = self._obeyed.get(goal.goal) == goal.admitted
        counted = GoodsCounted(
            goal.goal,
            goal.arrived,
            admitted,
            incarnation=goal.incarnation if obeyed else 0,
            number=goal.number if obeyed else 0,
            brought=goal.brought,
            by_people=self._late,
        )
        if goal.arrived > goal.heard:
            self._counts.say(goal.goal, Send(goal.asker, counted), now_s)
        else:
            self._life.send(goal.asker, counted)

    def _on_count_acknowledged(self, sender: str, message: CountAcknowledged, _now_s: float) -> None:
        goal = self._goals.get(message.goal)
        if goal is None or goal.asker != sender or message.arrived <= goal.heard:
            self._life.ignore("an acknowledgement of an old count, or by another strategist")
            return
        goal = replace(goal, heard=min(message.arrived, goal.arrived))
        self._goals.put(goal)
        if goal.heard == goal.arrived:
            self._counts.settle(goal.goal)

    # --- admissions ---

    def _on_admission(self, sender: str, asked: AdmissionAsked, now_s: float) -> None:
        goal = self._goals.get(asked.goal)
        of = asked.of if goal is None or goal.of is None else goal.of
        if of is not None:
            refusal = self._orders.refusal(sender, of.order, asked.held)
            if refusal is not None:
                self._life.send(sender, HolderReported(refusal))
                return
        word = (asked.incarnation, asked.number)
        if goal is None or goal.asker != sender:
            self._newest.forget(asked.goal)
        if goal is None:
            goal = GateGoal(asked.goal, sender, asked.quantity, *word, of=of)
        elif goal.asker == sender and self._is_outdated(word, goal, now_s):
            self._life.ignore("an outdated request about a goal")
            return
        else:
            heard = goal.heard if goal.asker == sender else 0
            goal = GateGoal(
                goal.goal,
                sender,
                asked.quantity,
                *word,
                arrived=goal.arrived,
                heard=heard,
                of=of,
                brought=goal.brought,
            )
        self._newest.takes(goal.goal, word, now_s)
        if self._goals.get(goal.goal) != goal:
            self._goals.put(goal)
        self._obeyed.pop(goal.goal, None)
        self._admit(goal)

    def _is_outdated(self, word: tuple[int, int], goal: GateGoal, now_s: float) -> bool:
        """Whether a request came after a later one about the same goal."""
        newest = (goal.incarnation, goal.number)
        return not self._newest.of(goal.goal, newest, now_s, self._begun_s).stands(word, now_s)

    def _admit(self, goal: GateGoal) -> None:
        """Tell the body the admitted quantity."""
        self._life.instruct(Admit(goal.goal, goal.admitted, arrived=goal.arrived if self._people else 0))

    # --- orders and their holders ---

    def _on_claimed(self, sender: str, claimed: OrderClaimed, now_s: float) -> None:
        being_shut = [goal for goal in self._goals.of_order(claimed.order) if self._is_being_shut(goal)]
        if being_shut and not claimed.over:
            # Their counts are not final: the next holder would have missing pieces made that may be in.
            for goal in being_shut:
                self._admit(goal)
            self._life.ignore("a claim of an order while the gate is being shut for a goal of it")
            return
        self._orders.make_again(sender, claimed.order, claimed.again)
        told = self._orders.claim(sender, claimed.order, claimed.epoch, claimed.over)
        if told.holder == sender:
            self._hand_over(claimed.order, sender)
            if loser := self._orders.loser(claimed.order):
                self._say_lost(claimed.order, loser, now_s)
        self._life.send(sender, HolderReported(told))

    def _hand_over(self, order: str, holder: str) -> None:
        """Redirect the counts of an order to its new holder."""
        for goal in self._goals.of_order(order):
            if goal.asker != holder:
                self._counts.settle(goal.goal)
                # The new holder's report of the order includes the count.
                self._goals.put(replace(goal, asker=holder, incarnation=0, number=0, heard=goal.arrived))

    def _say_lost(self, order: str, by: str, now_s: float) -> None:
        self._holders.say(order, Send(by, HolderReported(self._orders.told(order, by))), now_s)

    def _on_holder_acknowledged(self, sender: str, message: HolderAcknowledged, _now_s: float) -> None:
        if self._orders.heard(sender, message.order, message.epoch):
            self._holders.settle(message.order)

    # --- a strategist begins ---

    def _on_gate_asked(self, sender: str, asked: GateAsked, _now_s: float) -> None:
        if asked.forgotten and not self._is_shut_for(sender):
            self._life.ignore("a question that the gate answers once it is shut")
            return
        held, more = self._orders.held_by(sender, asked.after)
        self._life.send(sender, GateReported(asked.after, held, more, self._since))

    def _is_shut_for(self, strategist: str) -> bool:
        """Shut the gate for all goals of a strategist's earlier lives; returns whether it is shut."""
        is_shut = True
        for goal in self._goals:
            if goal.asker != strategist or 0 < goal.admitted <= goal.arrived:
                continue
            shut = goal
            if goal.admitted:
                # Earlier messages about it are old from now on.
                shut = replace(goal, admitted=0, number=goal.number + 1)
                self._goals.put(shut)
                self._obeyed.pop(goal.goal, None)
            if self._is_being_shut(shut):
                is_shut = False
                self._admit(shut)
        return is_shut

    def _is_being_shut(self, goal: GateGoal) -> bool:
        """Whether a goal has no admission, and the body has not confirmed that: its count is not final."""
        return not goal.admitted and self._obeyed.get(goal.goal) != 0


def _refuse(_command: MachineCommand, _grant: Grant, _now_s: float) -> CommandRefusal:
    """A gate has no commands but people's reports."""
    return CommandRefusal.NOT_SUPPORTED


def _detail(_command: MachineCommand, _refused: CommandRefusal) -> str:
    return NO_PEOPLE
