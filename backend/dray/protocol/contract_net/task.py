"""A coordinator's tasks: its record of each while it is open, and after it has ended."""

from __future__ import annotations

from typing import cast

from msgspec import UNSET

from dray.memory import DepartureMemory, TaskMemory
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
    """A carrier's report of the delivery, and what the coordinator counted of it."""

    __slots__ = ("booked", "counted", "said", "said_s")

    def __init__(self) -> None:
        self.counted = 0
        """Pieces that the coordinator saw put down in its own buffer."""
        self.said, self.said_s = 0, NEVER_S
        """Pieces that the carrier reports as put down, and when it first reported them."""
        self.booked = False
        """Whether a body that does not count was told of it, on the carrier's report."""


class CarrierContract:
    """The contract with a task's primary, as its coordinator knows it.

    Args:
        primary: the primary's id; empty for none.
        source: where the load is fetched; empty if unknown, and for goals.
        promised_s: promised finish.
        bound_s: begin of the contract.
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
        """Failure detector of the primary, while it is followed."""
        self.progress: Progress | None = None
        """Progress of the primary, while it is followed."""
        self.unnamed_s = NEVER_S
        """Since when the primary's heartbeat does not name the task."""
        self.forgotten_aboard = False
        """Whether the primary has forgotten the task with its thing on board."""
        self.phase: Phase | None = None
        """The primary's last reported phase; None before its first report."""
        self.phase_s = 0.0
        """Since when the primary has been in that phase."""
        self.held_s = NEVER_S
        """Since when it stands at the coordinator's dock without room, or without a load to fetch."""
        self.receipt = Receipt()


class StandbyContract:
    """The contract with a task's secondary, as its coordinator knows it.

    Args:
        secondary: the secondary's id; empty for none.
        number: of the award for the watch.
        bid: its bid to carry the task, made when it was asked to watch; None if an earlier life asked it.
        detector: failure detector of the secondary; None for none.
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
        """Since when the secondary's heartbeat does not name the watch."""


class OpenTask:
    """A task that has not ended, as its coordinator knows it.

    Args:
        task: its id.
        work: the work to do.
        auction: the auction for its primary.
        opened_s: time of the first announcement.
    """

    __slots__ = (
        "auction",
        "contract",
        "detail",
        "disputed_by",
        "disputes",
        "due_s",
        "epoch",
        "fails_at",
        "id",
        "least_epoch",
        "left",
        "opened_s",
        "perhaps_down",
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
        """Epoch: rises whenever the carrier changes; messages with a lower one are refused."""
        self.least_epoch = 0
        """A carrier was told that epochs below this one are invalid."""
        self.auction = auction
        self.watch: Auction | None = None
        """The auction for a secondary, while one is sought."""
        self.contract = CarrierContract()
        self.standby = StandbyContract()
        self.opened_s = opened_s
        self.due_s = auction.terms.deadline_s
        """The first deadline; the auction's deadline moves when no bidder can keep it."""
        self.recovered = False
        """Whether the task was recovered from its carrier's report alone. Its earlier epochs are lost with the notes, so it
        never gets a new epoch. Without its carrier it is withdrawn, and remaining demand is announced under another id.
        """
        self.witnessed = True
        """Whether this life of the coordinator saw all of it, so that the carrier's reports can be checked."""
        self.trouble: Reason | None = None
        """Why the task does not progress; None if it does."""
        self.detail = ""
        """The problem that its carrier reports."""
        self.disputes = 0
        """Handovers without a counted load since a person last looked."""
        self.disputed_by: tuple[str, ...] = ()
        """Their carriers, or those that have failed at `fails_at`, as far as this life knows."""
        self.left = False
        """While the task is held: its goods had left their machine."""
        self.perhaps_down: DepartureMemory | None = None
        """While the task is held: the load that its last carrier may have put down, and has forgotten."""
        self.fails_at = ""
        """While the task is held: the place where carriers have failed to load or unload it; empty for another reason."""
        self.stranded: StrandedGoods | None = None
        """Goods left on board of a failed carrier that no other carrier has yet."""

    def clear_trouble(self) -> None:
        """The task progresses again."""
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
        """Whether its load is on board of its carrier, even if the carrier is stranded."""
        return self.state in (TaskState.IN_TRANSIT, TaskState.STRANDED)

    @property
    def lies_at_source(self) -> bool:
        """Whether its load waits at its source: not on board, and not handed to a person."""
        elsewhere = self.is_loaded or self.left
        return not elsewhere and not (isinstance(self.work, Transport) and self.work.handed_at)

    @property
    def is_held(self) -> bool:
        """Whether a person must look for the load, or at a dock, before a vehicle carries it again."""
        return self.state is TaskState.HELD

    @property
    def is_counted(self) -> bool:
        """Whether its load was counted but not handed over yet."""
        return self.state is TaskState.COUNTED

    @property
    def deadline_s(self) -> float:
        return self.auction.terms.deadline_s

    @property
    def is_of_goods(self) -> bool:
        """Whether it carries products away, of which each piece exists once."""
        return isinstance(self.work, Transport) and bool(self.work.goal)

    @property
    def exists_once(self) -> bool:
        """Whether its load is irreplaceable while on board: products carried away, and a thing without master data."""
        return self.is_of_goods or self.is_thing

    @property
    def is_thing(self) -> bool:
        """Whether its load has no master data."""
        return isinstance(self.work, Transport) and self.work.item == THING

    @property
    def is_changing_hands(self) -> bool:
        """Whether its carrier last reported taking goods, unloading or handing over."""
        last = self.contract.detector.last if self.contract.detector is not None else None
        brief = last.task if last is not None else None
        if brief is None or brief.task != self.id:
            return False
        return brief.phase in _AT_THE_END or (self.is_of_goods and brief.phase is Phase.LOADING)

    @property
    def work_item(self) -> str:
        """The carried item, or the product."""
        return self.work.item if isinstance(self.work, Transport) else self.work.product

    def brief(self) -> TaskBrief:
        """The transport's entry in the heartbeat."""
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
            fails_at=self.fails_at,
        )

    def memory(self) -> TaskMemory:
        """The transport's record for its machine's next life."""
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
            perhaps_down=self.perhaps_down,
            fails_at=self.fails_at,
        )

    @property
    def round(self) -> int:
        return self.auction.round

    @property
    def is_offered(self) -> bool:
        """Whether the present epoch was announced, or offered to the secondary."""
        return self.auction.has_asked


class ClosedTask:
    """The record of an ended task."""

    __slots__ = ("carrier", "epoch", "outcome", "recovered")

    def __init__(self, carrier: str, epoch: int, outcome: Outcome, *, recovered: bool) -> None:
        self.carrier, self.epoch, self.outcome, self.recovered = carrier, epoch, outcome, recovered
