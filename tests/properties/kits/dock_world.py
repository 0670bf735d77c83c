"""One machine, one vehicle, and one load at its dock: what lies there, and what is in the books."""

from __future__ import annotations

from effects import committed, instructed, published, sent
from m7 import FULL, NO_HOUSINGS
from msgspec.structs import replace
from rigs import MachineRig
from spoken import production, rhb

from dray.body import Book, CloseDock, DockReady, OpenDock, StockChanged
from dray.memory import Memory
from dray.messages import (
    AtvHeartbeat,
    Docked,
    DockOpened,
    Handover,
    HandoverAccepted,
    Phase,
    Reason,
    Resigned,
    Role,
    StockAsked,
    StockFreed,
    StockReserved,
    Superseded,
    TaskAnnounced,
    Withdrawn,
)
from dray.plant import Plant
from dray.plant.file.file import shipped_plant
from dray.protocol.runtime.events import Effect, Event
from dray.protocol.transports.transports import RECOVERY_WAIT_S

CART = "ATV2"
LEVELS = shipped_plant("levels")


class DockRig(MachineRig):
    """A machine whose body books each report of a vehicle once, and answers at once, or counts."""

    world: DockWorld

    def handle(self, event: Event) -> list[Effect]:
        effects = super().handle(event)
        for effect in list(effects):
            effects += self.world.body_and_vehicle(effect)
        return effects


class DockWorld:
    """A vehicle that takes goods from LATHE1 for PRESS1 or pumps from M7 for M7 itself, or brings housings to M7.

    Args:
        takes: whether it takes its load; otherwise it brings it.
        answers: whether the dock takes time to open.
        counts: whether the body counts what is moved; otherwise it books what it is told.
        is_own: whether what it takes is carried for the machine itself.

    Attributes:
        loads: how many loads the vehicle has come for.
        moved: by task, the pieces that the vehicle's body has moved; negative for taken ones.
        is_forgotten: whether the vehicle has lost its memory since it came.
        lost_notes: how often the machine's agent has lost its notes since then.
        was_let_in: whether it was ever told to load or unload.
    """

    def __init__(self, *, takes: bool, answers: bool, counts: bool = False, is_own: bool = False) -> None:
        self.takes, self.answers, self.counts, self.is_own = takes, answers, counts, is_own
        is_fetched = takes and not is_own
        self.machine = "LATHE1" if is_fetched else "M7"
        self.plant: Plant | None = LEVELS if is_fetched else None
        self.task, self.item, self.pieces = ("PRESS1-1", "shaft", 6) if takes else ("M7-1", "housing", 24)
        self.coordinator = "PRESS1" if is_fetched else "M7"
        self.stock = {"bar": 60, "shaft": 12} if is_fetched else dict(FULL if takes else NO_HOUSINGS)
        self.answered: dict[tuple[str, str, int, bool], StockChanged] = {}
        self.opened: dict[str, OpenDock] = {}
        self.life, self.seq = 1, 0
        self.is_here, self.knows, self.has_load, self.is_moving = True, True, not takes, False
        self.has_moved = self.is_forgotten = self.is_void = self.is_deaf = self.has_told = False
        self.has_left_empty = self.was_let_in = False
        self.lost_notes = 0
        self.loads, self.moved = 1, dict[str, int]()
        self.elsewhere = ""
        self.rig = self._start(1, {})
        if is_fetched:
            self.rig.on_message("PRESS1", StockAsked(self.task, 1, self.item, self.pieces))
        elif takes:
            self.item, self.pieces = "pump-p3", 24
            self.rig.take_goal("G1", production(quantity=24))
            self.rig.cycles(24)
            self.task = next(
                each.task
                for each in published(self.rig.all, TaskAnnounced)
                if each.work.destination == "DELIVERY"
            )
            self.rig.hire(self.task, CART)
        else:
            self.rig.take_goal("G1", production(quantity=24))
            self.rig.hire(self.task, CART)
        self.asks()

    def _start(self, incarnation: int, memory: Memory) -> DockRig:
        options = {} if self.plant is None else {"plant": self.plant}
        rig = DockRig(self.machine, self.stock, incarnation=incarnation, **options)
        rig.world, rig.memory, rig.answers, rig.counts = self, memory, self.answers, self.counts
        before = getattr(self, "rig", None)
        if before is not None:
            rig.now_s, rig.seq, rig.stock = before.now_s, before.seq, before.stock
        rig.opened = tuple(self.opened)
        rig.let_in = next(iter(self.opened.values()), None)
        self.rig = rig
        rig.start()
        return rig

    # --- the body of the machine, and what the vehicle hears ---

    def body_and_vehicle(self, effect: Effect) -> list[Effect]:
        """What follows from what the machine's agent wants done."""
        for book in instructed([effect], Book):
            return self._book(book)
        for opens in instructed([effect], OpenDock):
            self.opened = {opens.vehicle: opens}
        for closes in instructed([effect], CloseDock):
            self.opened.pop(closes.vehicle, None)
        self.was_let_in |= bool(sent([effect], DockOpened, to=CART))
        if not self.knows or self.is_deaf:
            return []
        for told in sent([effect], DockOpened, to=CART):
            self.is_moving |= told.task == self.task and self.is_here and not self.has_moved
        for over in (*sent([effect], Superseded, to=CART), *sent([effect], Withdrawn, to=CART)):
            # What it has put down it has told of until then.
            if over.task == self.task and (self.takes or not self.has_moved or self.has_told):
                self.is_void = True
                self.knows = self.is_moving or (self.has_load and self.is_here)
        if sent([effect], HandoverAccepted, to=CART):
            self.knows = False
        return []

    def _book(self, book: Book) -> list[Effect]:
        assert not self.counts
        return self.rig.report(self._counted(book))

    def _counted(self, book: Book) -> StockChanged:
        self.opened.pop(book.vehicle, None)
        key = (book.vehicle, book.task, book.epoch, book.change > 0)
        if key not in self.answered:
            self.rig.stock[book.item] += book.change
            self.rig.seq += 1
            self.answered[key] = StockChanged(book.item, book.change, self.rig.seq, book.vehicle)
        return self.answered[key]

    # --- what may happen ---

    def asks(self) -> None:
        """It stands there and asks for the dock."""
        if self.is_here and self.knows and not (self.is_moving or self.has_moved or self.is_void):
            quantity, item = (self.pieces, self.item) if self.takes else (0, "")
            self.rig.on_message(CART, Docked(self.task, 1, self.machine, item, quantity))

    def is_ready(self) -> None:
        """The body has opened the dock."""
        if self.answers and CART in self.opened:
            self.rig.report(DockReady(vehicle=CART))

    def moves(self) -> None:
        """Its body moves the load."""
        if self.is_moving:
            self.has_load, self.is_moving, self.has_moved = self.takes, False, True
            self.moved[self.task] = change = -self.pieces if self.takes else self.pieces
            if self.counts:
                self.rig.report(self._counted(Book(CART, self.item, change, task=self.task, epoch=1)))

    def tells(self) -> None:
        """Its heartbeat is heard, and its coordinator answers what it is asked."""
        self.rig.run(self.rig.now_s + 1.0)
        self.seq += 1
        effects = self.rig.on_message(CART, self._heartbeat())
        for asked in sent(effects, StockReserved, to="PRESS1"):
            fetched = asked.task in self.moved or self.is_forgotten
            self.rig.on_message("PRESS1", StockFreed(asked.task, fetched=fetched))
        if self.has_moved and self.knows and not self.takes:
            self.has_told = True
            self.rig.on_message(CART, Handover(self.task, 1, self.pieces))

    def _heartbeat(self) -> AtvHeartbeat:
        task, phase = self.elsewhere, Phase.APPROACHING
        if self.knows:
            task = self.task
            if self.is_moving:
                phase = Phase.LOADING if self.takes else Phase.UNLOADING
            elif self.is_void:
                phase = Phase.RETURNING
            elif self.has_load:
                phase = Phase.CARRYING if self.takes else Phase.UNLOADING
            elif self.has_moved:
                phase = Phase.HANDING_OVER
            else:
                phase = Phase.LOADING
        elif self.has_load and not task:
            task, phase = f"{CART}-found-{self.life}", Phase.RETURNING
        coordinator = self.coordinator if self.knows else "PRESS2"
        beat = rhb(CART, self.seq, self.rig.now_s, task=task, coordinator=coordinator)
        doing = beat.task
        if doing is not None:
            doing = replace(doing, phase=phase, item=self.item, quantity=self.pieces)
        dock = self.rig.agent._plant.node_of(self.machine)
        beat = replace(
            beat, node=dock if self.is_here else "far", left_empty=dock if self.has_left_empty else ""
        )
        load = (self.item, self.pieces) if self.has_load else ("", 0)
        return replace(beat, task=doing, incarnation=self.life, load=load[0], load_quantity=load[1])

    def is_silent(self) -> None:
        """It is not heard for a while, and hears nothing."""
        self.is_deaf = True
        self.rig.run(self.rig.now_s + 20.0)
        self.is_deaf = False

    def restarts(self) -> None:
        """Its agent is started again."""
        self.life, self.seq = self.life + 1, 0

    def forgets(self) -> None:
        """Its agent is started again without notes; its body goes on."""
        if self.is_here:
            self.restarts()
            self.is_forgotten, self.knows = True, False

    def gives_back(self) -> None:
        """It gives its transport back, or its coordinator needs the load no more."""
        if self.takes and not self.has_moved:
            gives_up = StockFreed(self.task)
            if self.is_own:
                gives_up = Resigned(self.task, 1, Role.PRIMARY, Reason.PROBLEM)
            self.rig.on_message(CART if self.is_own else "PRESS1", gives_up)
            self.is_void = True
            self.knows = self.knows and self.is_moving
        elif not self.takes and self.knows and not self.has_moved:
            self.rig.on_message(CART, Resigned(self.task, 1, Role.PRIMARY, Reason.PROBLEM))

    def leaves(self) -> None:
        """It drives off, if its body does nothing; then it works for somebody else, who wants the same."""
        if not self.is_here or self.is_moving:
            return
        if self.knows and not (self.has_moved or self.is_void):
            return
        self.is_here = False
        self.has_left_empty = self.is_forgotten and not self.has_load

    def comes_back(self) -> None:
        """It comes for a second load."""
        if (
            self.takes
            and not self.is_own
            and not (self.is_here or self.knows or self.has_load or self.task == "PRESS1-2")
        ):
            self.tells()
            self.task, self.elsewhere, self.loads = "PRESS1-2", "", 2
            self.is_here = self.knows = True
            self.has_moved = self.is_void = self.has_left_empty = False
            self.rig.on_message("PRESS1", StockAsked(self.task, 1, self.item, self.pieces))
            self.asks()

    def works_elsewhere(self) -> None:
        """It has put its load down elsewhere, and has another task."""
        if not self.is_here and (self.takes or not (self.knows or self.has_load)):
            if self.knows or self.has_load:
                self.is_silent()
            self.elsewhere, self.knows, self.has_load = "PRESS2-7", False, False

    def loads_elsewhere(self) -> None:
        """It has such a load from elsewhere on board."""
        if self.elsewhere and not self.is_here:
            self.tells()
            self.has_load = True

    def machine_restarts(self) -> None:
        """The machine's agent is started again."""
        memory = committed(self.rig.all) or self.rig.memory
        self._start(self.rig.agent.incarnation + 1, memory)

    def machine_forgets(self) -> None:
        """The machine's agent is started again without notes."""
        self.lost_notes += 1
        self._start(self.rig.agent.incarnation + 1, {})

    # --- the end ---

    def settle(self) -> None:
        """All are heard, the vehicle leaves, and whoever is asked answers."""
        for _ in range(int(RECOVERY_WAIT_S) + 2):
            self.tells()
        for _ in range(3):
            self.asks()
            self.is_ready()
            self.tells()
            self.moves()
            self.tells()
        if self.knows and not (self.has_moved or self.is_void):
            self.gives_back()  # It is not let in: it gives up, as after a while in service.
            self.is_void = True
        for _ in range(12):
            self.leaves()
            self.tells()
            self.rig.run(self.rig.now_s + 4.0)

    @property
    def booked(self) -> int:
        """Pieces of the load in the books; negative for taken ones."""
        return sum(report.change for report in self.answered.values())
