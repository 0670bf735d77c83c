"""A transport on the lanes: the ways to its stations, when it will be there, and what is closed in between."""

from __future__ import annotations

from math import inf

from dray.errors import NoWay
from dray.memory import Contract
from dray.messages import THING, Reason
from dray.protocol.vehicle.job.job_moves import JobMoves
from dray.protocol.vehicle.job.job_state import LOADED, JobState
from dray.protocol.vehicle.job.job_status import JobStatus
from dray.protocol.vehicle.people.assistance import Waiting

ASKS_AGAIN_S = 300.0
"""Who has a contract for a load that was only to be had behind a silent vehicle gives it back after this: by then others may have it."""


class JobWays(JobStatus):
    """Drives one transport to its stations.

    Args:
        contract: what the vehicle is bound to.
        moves: what the vehicle does for it.
    """

    def __init__(self, contract: Contract, moves: JobMoves) -> None:
        super().__init__(contract)
        self._moves = moves
        self._station = contract.source
        """Where it drives to, or stands."""
        self._cut_off = False
        """What is closed leaves no way to its station: it stands elsewhere, and waits."""
        self._was_shut_out = moves.is_shut_out_of(contract.source)
        """Something was known to be in the way to the source when the contract was made: nobody else had the load then."""
        self._short = ""
        """The storage that had none of the load, or cannot be reached, which is why it was given back."""

    def floor_changed(self, now_s: float) -> None:
        """People have closed or opened something: go on by what is open. Whoever is at a dock finishes there first."""
        if self.state in (JobState.APPROACHING, JobState.CARRYING, JobState.RETURNING):
            self._drive_on(now_s)
        elif self.is_given_back:
            self._moves.halt(now_s)

    def shut_out(self, by: str, waited_s: float, now_s: float) -> None:
        """A silent vehicle is in its way, and none leads round: the load is fetched elsewhere, or brought elsewhere.

        What is only to be had there, or is to be brought there, waits.

        Args:
            by: the silent vehicle.
            waited_s: how long it has been waited for.
            now_s: the present time.
        """
        waits_s = ASKS_AGAIN_S if self._was_shut_out else 0.0
        if self.state is JobState.APPROACHING and waited_s >= waits_s and self._moves.can_fetch_elsewhere():
            self._short = self.source
            self.give_back(Reason.WAY_BLOCKED, now_s, by)
        elif self.state is JobState.RETURNING and (refuge := self._moves.refuge()) != self._station:
            self._station = refuge
            self._drive(refuge, now_s)

    def waiting(self, now_s: float) -> Waiting:
        """What it means for the task that the vehicle cannot go on."""
        loaded = self.state in LOADED
        relief_s = 0.0
        if loaded:
            try:
                relief_s = self._moves.from_source_s() - max(0.0, self.due_s - now_s)
            except NoWay:
                relief_s = inf
        once = loaded and (bool(self.work.goal) or self.work.item == THING)
        return Waiting(self.task, self.slack_s, relief_s, irreplaceable=once or self.is_void)

    def arrived(self, now_s: float) -> None:
        """The vehicle stands where it was sent."""
        raise NotImplementedError

    def give_back(self, reason: Reason, now_s: float, detail: str = "") -> None:
        """Stand, and ask the coordinator to let another one carry it; `detail` tells people more."""
        raise NotImplementedError

    def _drive(self, station: str, now_s: float) -> None:
        """Drive to a station; it has arrived at once where it stands there."""
        self._cut_off = False
        try:
            there_s = self._moves.drive(station, now_s)
            arrives_s = now_s if there_s is None else there_s
            if self.state is JobState.APPROACHING:
                self.due_s = arrives_s + self._moves.from_source_s()
                self._moves.expect_to_load(arrives_s)
                self._moves.expect_to_unload(self.due_s - self._moves.unloading_s())
            elif self.state is JobState.CARRYING:
                self.due_s = arrives_s + self._moves.unloading_s()
                self._moves.expect_to_unload(arrives_s)
        except NoWay:
            self._wait_for_way(now_s)
            return
        if there_s is None:
            self.arrived(now_s)

    def _drive_on(self, now_s: float) -> None:
        """Drive to its station, or to another one that keeps the load where that was closed."""
        if self._cut_off and self.state is JobState.RETURNING:
            self._station = self._moves.refuge()
        self._drive(self._station, now_s)

    def _wait_for_way(self, now_s: float) -> None:
        """What is closed leaves no way: another one is to fetch the load, and what is on board waits with the vehicle."""
        self._cut_off = True
        if self.state is JobState.APPROACHING:
            self.give_back(Reason.CLOSED, now_s)
        else:
            self._moves.halt(now_s)
            self._moves.try_later(now_s)

    def _keeps_promise(self, now_s: float) -> bool:
        """Whether it would be done in time if it were loaded now."""
        try:
            return now_s + self._moves.from_source_s() <= self.promised_s
        except NoWay:
            return False
