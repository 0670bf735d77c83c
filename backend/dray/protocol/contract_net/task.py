"""A coordinator's tasks: what it knows of each while it is open, and after it has ended."""

from __future__ import annotations

from typing import Literal, cast

from dray.memory import TaskMemory
from dray.messages import Bid, Phase, TaskBrief, Transport, Work
from dray.protocol.contract_net.auction import Auction
from dray.protocol.liveness.failure_detector import FailureDetector
from dray.protocol.liveness.progress import Progress
from dray.protocol.runtime.events import NEVER_S

Outcome = Literal["delivered", "withdrawn"]

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


class OpenTask:
    """A task that has not ended, as its coordinator knows it."""

    __slots__ = (
        "adopted",
        "auction",
        "awaits_takeover",
        "detector",
        "due_s",
        "epoch",
        "held_s",
        "id",
        "loaded",
        "opened_s",
        "phase",
        "phase_s",
        "primary",
        "progress",
        "promised_s",
        "receipt",
        "secondary",
        "source",
        "standby_detector",
        "trouble",
        "unloaded",
        "unnamed_s",
        "unwatched_s",
        "watch",
        "watch_bid",
        "watch_number",
        "witnessed",
        "work",
    )

    def __init__(self, task: str, work: Work, auction: Auction, opened_s: float) -> None:
        self.id = task
        self.work = work
        self.epoch = auction.terms.epoch
        """Rises whenever the carrier changes; whatever comes with a lower one is refused."""
        self.auction = auction
        self.watch: Auction | None = None
        """The auction for a secondary, while one is sought."""
        self.primary = ""
        self.secondary = ""
        self.watch_bid: Bid | None = None
        """What the secondary would carry it for, when it was asked to watch; None if an earlier life has asked it."""
        self.watch_number = 0
        """Of the award by which the secondary watches."""
        self.source = ""
        self.promised_s = 0.0
        """When the primary has promised to be done."""
        self.detector: FailureDetector | None = None
        """The watch over the primary."""
        self.progress: Progress | None = None
        """How the primary comes on."""
        self.standby_detector: FailureDetector | None = None
        """The watch over the secondary."""
        self.opened_s = opened_s
        self.due_s = auction.terms.deadline_s
        """The first deadline; that of the auction moves when nobody could keep it."""
        self.adopted = False
        """Taken up on its carrier's word alone: which epochs it has had is in notes that are lost, so it never gets
        another one. Without its carrier it is withdrawn, and what is still needed is announced under another name."""
        self.loaded = False
        """FinishedGoods that have left this machine: nobody else can fetch them again."""
        self.unloaded = False
        """The coordinator has seen the load put down in its own buffer; the handover is still to come."""
        self.receipt = Receipt()
        """What its carrier says of the load, and what was counted."""
        self.witnessed = True
        """This life of the coordinator has seen all of it: what a carrier says of the load is compared with that."""
        self.held_s = NEVER_S
        """Since when its carrier stands at this machine's dock and finds no room, or nothing to fetch."""
        self.trouble = ""
        """Why it does not go on, in words."""
        self.awaits_takeover = False
        """The primary has failed, and the secondary may still take over."""
        self.phase: Phase | None = None
        """How far its primary had come when it was heard last; None before it has said so."""
        self.phase_s = 0.0
        """Since when it has been heard in that phase."""
        self.unnamed_s = NEVER_S
        """Since when the primary does not name this task in its heartbeat."""
        self.unwatched_s = NEVER_S
        """Since when the secondary does not."""

    @property
    def deadline_s(self) -> float:
        return self.auction.terms.deadline_s

    @property
    def is_of_goods(self) -> bool:
        """Whether products are carried away, of which each piece exists once."""
        return isinstance(self.work, Transport) and bool(self.work.goal)

    @property
    def is_changing_hands(self) -> bool:
        """Whether its carrier takes goods, puts material down or hands over, as it has told last."""
        last = self.detector.last if self.detector is not None else None
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
            source=self.source,
            destination=work.destination,
            deadline_s=self.deadline_s,
            primary=self.primary,
            secondary=self.secondary,
            round=self.round,
            trouble=self.trouble,
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
            source=self.source,
            promised_s=self.promised_s,
            loaded=self.loaded,
            secondary=self.secondary,
            watch_number=self.watch_number,
            offered=self.is_offered,
            adopted=self.adopted,
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
