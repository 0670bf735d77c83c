"""A machine's body that is people, with a clock and a disk that are turned by hand."""

from __future__ import annotations

from collections.abc import Callable
from itertools import count

from dray.adapters.people.workcell import Kept, PeopleWorkcell
from dray.body import Book, Report, StartCycle, Word, WordTaken, WorkcellState
from dray.messages import CommandRefusal, MachineCommandKind
from dray.plant import default_plant

PLANT = default_plant()
SPEC = PLANT.machines["M1"]
PRODUCT = SPEC.makes[0].product
CYCLE_S = SPEC.makes[0].cycle_s
BILL = {line.material: line.quantity for line in PLANT.products[PRODUCT].bill}
ITEM = next(iter(BILL))
FULL = dict.fromkeys(BILL, 20)
KIND = MachineCommandKind


class PeopleRig:
    """One machine, over several lives of its agent.

    Args:
        stock: what people have counted at the beginning.

    Attributes:
        now_s: the plant's time.
        kept: what is on the disk.
        told: what was on the disk when each report was made.
    """

    def __init__(self, stock: dict[str, int] | None = None) -> None:
        self.now_s = 1_000.0
        self.kept: Kept | None = None
        self.reports: list[Report] = []
        self.told: list[Kept | None] = []
        self._names = count(1)
        self.begin()
        for item, pieces in (FULL if stock is None else stock).items():
            assert self.says(KIND.STOCK_IS, pieces, item, sure=True) == (None, "")
        self.heard()

    def begin(self) -> None:
        """Another life of its agent: of the last one only what was remembered is left."""
        self.body = PeopleWorkcell(SPEC, PLANT, _Clock(self), self, self.kept)
        self.body.attach(self._hear)

    def remember(self, kept: Kept) -> None:
        self.kept = kept

    def _hear(self, report: Report) -> None:
        self.reports.append(report)
        self.told.append(self.kept)

    def says(
        self,
        kind: MachineCommandKind,
        quantity: int = 1,
        item: str = "",
        *,
        vehicle: str = "",
        sure: bool = False,
        key: str = "",
    ) -> tuple[CommandRefusal | None, str]:
        """What became of a word, and the expected number."""
        key = key or f"maria/{next(self._names)}"
        self.body.instruct(Word(key, kind, item, quantity, vehicle, sure))
        taken = self.reports[-1]
        assert isinstance(taken, WordTaken)
        assert taken.key == key
        return taken.refused, taken.detail

    def book(self, vehicle: str, item: str, change: int, task: str = "") -> None:
        """A vehicle says what it has brought or taken, by a transport of its own where none is named."""
        task = task or f"{SPEC.id}-{next(self._names)}"
        self.body.instruct(Book(vehicle, item, change, task=task, epoch=1))

    def start(self, product: str = PRODUCT) -> None:
        self.body.instruct(StartCycle(product=product))

    @property
    def state(self) -> WorkcellState:
        return self.body.sense()

    def heard(self) -> list[Report]:
        """What was reported since this was asked last, but answers."""
        heard = [report for report in self.reports if not isinstance(report, WordTaken)]
        self.reports.clear()
        return heard


class _Clock:
    """Implements `dray.ports.Clock`."""

    def __init__(self, rig: PeopleRig) -> None:
        self._rig = rig

    def now_s(self) -> float:
        return self._rig.now_s

    def call_at(self, when_s: float, callback: Callable[[], None]) -> None:
        raise AssertionError("people are waited for by nobody")
