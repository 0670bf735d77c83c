"""A coordinator's tasks: what it knows of each while it is open, and after it has ended."""

from __future__ import annotations

from typing import cast

from msgspec import UNSET

from dray.memory import TaskMemory
from dray.messages import THING, Bid, Phase, Reason, StrandedGoods, TaskBrief, Transport, Work
from dray.messages.fact import Outcome
from dray.protocol.contract_net.auction import Auction
from dray.protocol.contract_net.task_state import TRANSITIONS, TaskState
from dray.protocol.liveness.failure_detector import FailureDetector
from dray.protocol.liveness.progress import Progress
from dray.protocol.runtime.events import NEVER_S
from dray.states import States

_AT_THE_END = frozenset({Phase.UNLOADING, Phase.HANDING_OVER})


class Receipt:
    """What a carrier says of its load's end, and what the coordinator has counted of it."""

    __slots__ = ("booked", "counted", "said", "said_s")

    def __init__(self) -> None:
        self.counted = 0
        """Pieces that the coordinator has seen put down in its own buffer."""
        self.said, self.said_s = 0, NEVER_S
        """Pieces that its carrier says to have put down, and when it has said so first."""
        self.booked = False
        """A body that does not count was told of it, on the carrier's word."""


class CarrierContract:
    """The contract with a task's primary, as its coordinator knows it.

    Args:
        primary: who has it; empty for nobody.
        source: where the load is fetched; empty where that is not known, and for goals.
        promised_s: when the primary has promised to be done.
        bound_s: since when it has the contract.
    """

    __slots__ = (
        "bound_s",
        "detector",
        "first_promised_s",
        "forgotten_aboard",
        "held_s",
        "phase",
        "phase_s",
        "primary",
        "progress",
        "promised_s",
        "receipt",
        "source",
        "unnamed_s",
    )

    def __init__(
        self, primary: str = "", source: str = "", promised_s: float = 0.0, bound_s: float = 0.0
    ) -> None:
        self.primary = primary
        self.source = source
        self.bound_s = bound_s
        self.first_promised_s = self.promised_s = promised_s
        self.detector: FailureDetector | None = None
        """Of the primary, while it is followed."""
        self.progress: Progress | None = None
        """How the primary comes on, while it is followed."""
        self.unnamed_s = NEVER_S
        """Since when the primary does not name the task in its heartbeat."""
        self.forgotten_aboard = False
        """The primary has forgotten it, and had its thing on board then."""
        self.phase: Phase | None = None
        """How far the primary had come when it was heard last; None before it has said so."""
        self.phase_s = 0.0
        """Since when it has been heard in that phase."""
        self.held_s = NEVER_S
        """Since when it stands at the coordinator's dock and finds no room, or nothing to fetch."""
        self.receipt = Receipt()


class StandbyContract:
    """The contract with a task's secondary, as its coordinator knows it.

    Args:
        secondary: who watches; empty for nobody.
        number: of the award by which it watches.
        bid: what it would carry the task for, when it was asked to watch; None if an earlier life has asked it.
        detector: of the secondary; None for nobody.
    """

    __slots__ = ("bid", "detector", "number", "secondary", "unnamed_s")

    def __init__(
        self,
        secondary: str = "",
        number: int = 0,
        bid: Bid | None = None,
        detector: FailureDetector | None = None,
    ) -> None:
        self.secondary = secondary
        self.number = number
        self.bid = bid
        self.detector = detector
        self.unnamed_s = NEVER_S
        """Since when the secondary does not name the watch in its heartbeat."""


class OpenTask:
    """A task that has not ended, as its coordinator knows it.

    Args:
        task: its id.
        work: what is to be done.
        auction: for its primary.
        opened_s: when it was announced first.
    """

    __slots__ = (
        "auction",
        "contract",
        "detail",
        "disputes",
        "due_s",
        "epoch",
        "id",
        "least_epoch",
        "left",
        "opened_s",
        "recovered",
        "standby",
        "states",
        "stranded",
        "trouble",
        "watch",
        "witnessed",
        "work",
    )

    def __init__(self, task: str, work: Work, auction: Auction, opened_s: float) -> None:
        self.id = task
        self.work = work
        self.states = States("a task", TRANSITIONS, TaskState.UNASSIGNED)
        self.epoch = auction.terms.epoch
        """Rises whenever the carrier changes; whatever comes with a lower one is refused."""
        self.least_epoch = 0
        """A carrier was told that no epoch below this one is right any more."""
        self.auction = auction
        self.watch: Auction | None = None
        """The auction for a secondary, while one is sought."""
        self.contract = CarrierContract()
        self.standby = StandbyContract()
        self.opened_s = opened_s
        self.due_s = auction.terms.deadline_s
        """The first deadline; that of the auction moves when nobody could keep it."""
        self.recovered = False
        """Taken up on its carrier's word alone: which epochs it has had is in notes that are lost, so it never gets
        another one. Without its carrier it is withdrawn, and what is still needed is announced under another name."""
        self.witnessed = True
        """This life of the coordinator has seen all of it: what a carrier says of the load is compared with that."""
        self.trouble: Reason | None = None
        """Why it does not go on; None when all is well."""
        self.detail = ""
        """Which problem its carrier reports."""
        self.disputes = 0
        """How often its carrier has handed over and nothing was counted, since a person has looked last."""
        self.left = False
        """While it is held: its goods had left their machine."""
        self.stranded: StrandedGoods | None = None
        """Its goods were left with a carrier that has failed, and no other one has them on board yet."""

    def clear_trouble(self) -> None:
        """It goes on."""
        self.trouble, self.detail = None, ""

    def assign(self, contract: CarrierContract) -> None:
        """Bind a contractor to the task."""
        self.states.enter(TaskState.ASSIGNED)
        self.contract = contract

    @property
    def state(self) -> TaskState:
        return self.states.now

    @property
    def primary(self) -> str:
        return self.contract.primary

    @property
    def secondary(self) -> str:
        return self.standby.secondary

    @property
    def is_loaded(self) -> bool:
        """Whether goods, or a thing, are on board of its carrier, whether or not that can go on."""
        return self.state in (TaskState.IN_TRANSIT, TaskState.STRANDED)

    @property
    def lies_at_source(self) -> bool:
        """Whether its load waits where it was made: on board of nobody, and in nobody's hands."""
        elsewhere = self.is_loaded or self.left
        return not elsewhere and not (isinstance(self.work, Transport) and self.work.handed_at)

    @property
    def is_held(self) -> bool:
        """Whether a person is to look whether its load is there, before anybody carries it again."""
        return self.state is TaskState.HELD

    @property
    def is_counted(self) -> bool:
        """Whether its load was seen put down, and not handed over yet."""
        return self.state is TaskState.COUNTED

    @property
    def deadline_s(self) -> float:
        return self.auction.terms.deadline_s

    @property
    def is_of_goods(self) -> bool:
        """Whether products are carried away, of which each piece exists once."""
        return isinstance(self.work, Transport) and bool(self.work.goal)

    @property
    def exists_once(self) -> bool:
        """Whether nobody could fetch its load again while it is on board: products that are carried away, and a thing without master data."""
        return self.is_of_goods or self.is_thing

    @property
    def is_thing(self) -> bool:
        """Whether its load has no master data."""
        return isinstance(self.work, Transport) and self.work.item == THING

    @property
    def is_changing_hands(self) -> bool:
        """Whether its carrier takes goods, puts material down or hands over, as it has told last."""
        last = self.contract.detector.last if self.contract.detector is not None else None
        brief = last.task if last is not None else None
        if brief is None or brief.task != self.id:
            return False
        return brief.phase in _AT_THE_END or (self.is_of_goods and brief.phase is Phase.LOADING)

    @property
    def work_item(self) -> str:
        """What is carried, or made."""
        return self.work.item if isinstance(self.work, Transport) else self.work.product

    def brief(self) -> TaskBrief:
        """What the heartbeat tells of a transport."""
        work = cast(Transport, self.work)
        return TaskBrief(
            task=self.id,
            epoch=self.epoch,
            item=work.item,
            quantity=work.quantity,
            source=self.contract.source,
            destination=work.destination,
            deadline_s=self.deadline_s,
            primary=self.primary,
            secondary=self.secondary,
            round=self.round,
            trouble=self.trouble,
            detail=self.detail,
            stranded=UNSET if self.stranded is None else self.stranded,
        )

    def memory(self) -> TaskMemory:
        """A transport for its machine's next life."""
        return TaskMemory(
            task=self.id,
            epoch=self.epoch,
            work=cast(Transport, self.work),
            deadline_s=self.due_s,
            opened_s=self.opened_s,
            primary=self.primary,
            source=self.contract.source,
            promised_s=self.contract.promised_s,
            loaded=self.is_loaded or self.left,
            secondary=self.secondary,
            watch_number=self.standby.number,
            offered=self.is_offered,
            recovered=self.recovered,
            least_epoch=self.least_epoch,
            stranded=self.stranded,
            forgotten_aboard=self.contract.forgotten_aboard,
            disputes=self.disputes,
            held=self.is_held,
        )

    @property
    def round(self) -> int:
        return self.auction.round

    @property
    def is_offered(self) -> bool:
        """Whether anybody was asked to carry it in its present epoch: all by an announcement, or its secondary."""
        return self.auction.has_asked


class ClosedTask:
    """What must still be known of a task that has ended."""

    __slots__ = ("carrier", "epoch", "outcome")

    def __init__(self, carrier: str, epoch: int, outcome: Outcome) -> None:
        self.carrier, self.epoch, self.outcome = carrier, epoch, outcome
