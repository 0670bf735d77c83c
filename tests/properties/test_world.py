"""A small world under an adversary: whatever fails and comes back, the invariants hold, and all ends well.

The adversary cuts agents off, loses, doubles, delays and reorders messages, lets software crash and vehicles
lose power, asks agents to leave, breaks vehicles down, lets forks slip, and stops vehicles. When it has had its
fun, everything is brought back, and what was ordered must be delivered.
"""

from __future__ import annotations

import hypothesis.strategies as st
from examples import examples
from hypothesis import note, settings
from hypothesis.stateful import RuleBasedStateMachine, initialize, rule
from world import World

from dray.body import Drop, Pick
from dray.messages import CommandKind, Link
from dray.messages.keys import STRATEGIST

VEHICLES = {"ATV1": "p3", "ATV2": "s3", "ATV3": "p1"}
ATVS = st.sampled_from(sorted(VEHICLES))
AGENTS = st.sampled_from([*sorted(VEHICLES), "M7", STRATEGIST])

COMMANDS = (CommandKind.STOP, CommandKind.ACKNOWLEDGE, CommandKind.RESUME)

SETTLE_S = 4000.0
"""Longer than goods on board of a silent vehicle are waited for, and then made and carried anew."""

SHOWN = 150
"""Lines of the log that a failure shows."""


class Adversary(RuleBasedStateMachine):
    """One run of the world."""

    @initialize(seed=st.integers(0, 2**16), quantity=st.integers(1, 5))
    def begin(self, seed: int, quantity: int) -> None:
        self.world = World(seed, VEHICLES)
        self.quantity = quantity
        self.world.order("O1", "pump-p3", quantity)
        self.passes(1.0)

    @rule(span_s=st.sampled_from([0.03, 0.3, 2.0, 7.0, 7.0, 25.0, 60.0]))
    def passes(self, span_s: float) -> None:
        self.world.run(self.world.now_s + span_s)

    @rule(atv=ATVS, later_s=st.sampled_from([0.0, 2.0, 4.99]))
    def passes_until_a_load_changes_hands(self, atv: str, later_s: float) -> None:
        """The tenderest moment: whatever fails now, the load must be somewhere."""
        world = self.world
        vehicle = world.vehicles[atv]
        world.run_until(lambda: isinstance(vehicle.action, Pick | Drop), 150.0, step_s=0.5)
        self.passes(later_s)

    @rule(
        loss_frac=st.sampled_from([0.0, 0.05, 0.3, 0.6]),
        double_frac=st.sampled_from([0.0, 0.3]),
        latency_s=st.sampled_from([0.01, 0.5, 3.0]),
        jitter_s=st.sampled_from([0.0, 1.0, 4.0]),
    )
    def network_changes(
        self, loss_frac: float, double_frac: float, latency_s: float, jitter_s: float
    ) -> None:
        network = self.world.network
        network.loss_frac, network.double_frac = loss_frac, double_frac
        network.latency_s, network.jitter_s = latency_s, jitter_s

    @rule()
    def network_heals(self) -> None:
        self.world.network.heal()

    @rule(agent=AGENTS)
    def is_cut_off(self, agent: str) -> None:
        self.world.network.cut_off.add(agent)

    @rule(agent=AGENTS)
    def crashes(self, agent: str) -> None:
        if self.world.is_up(agent):
            self.world.crash(agent)

    @rule(agent=AGENTS, down_s=st.sampled_from([0.1, 3.0, 10.0, 45.0]))
    def crashes_and_starts(self, agent: str, down_s: float) -> None:
        self.crashes(agent)
        self.passes(down_s)
        self.starts(agent)

    @rule(agent=AGENTS)
    def is_asked_to_leave(self, agent: str) -> None:
        if self.world.is_up(agent):
            self.world.leave(agent)

    @rule(agent=AGENTS, away_s=st.sampled_from([0.1, 3.0, 10.0, 45.0]))
    def leaves_and_starts(self, agent: str, away_s: float) -> None:
        """Its next life begins so much later; one that has not left by then is ended, as a service manager does."""
        self.is_asked_to_leave(agent)
        self.passes(away_s)
        self.crashes(agent)
        self.starts(agent)

    @rule(atv=ATVS, away_s=st.sampled_from([2.0, 6.0, 30.0]))
    def is_out_of_touch_for_a_while(self, atv: str, away_s: float) -> None:
        """It goes on as if nothing were, and comes back when others have taken its task."""
        self.is_cut_off(atv)
        self.passes(away_s)
        self.world.network.cut_off.discard(atv)

    @rule(atv=ATVS, link=st.sampled_from(Link))
    def link_changes(self, atv: str, link: Link) -> None:
        self.world.notice_link(atv, link)

    @rule(atv=ATVS)
    def loses_power(self, atv: str) -> None:
        if self.world.is_up(atv):
            self.world.power_off(atv)

    @rule(agent=AGENTS)
    def starts(self, agent: str) -> None:
        if not self.world.is_up(agent):
            self.world.start(agent)

    @rule(atv=ATVS)
    def breaks_down(self, atv: str) -> None:
        self.world.break_down(atv)

    @rule(atv=ATVS)
    def is_repaired(self, atv: str) -> None:
        self.world.repair(atv)

    @rule(atv=ATVS)
    def fork_slips(self, atv: str) -> None:
        self.world.failing[atv] += 1

    @rule(atv=ATVS, kinds=st.lists(st.sampled_from(COMMANDS), min_size=1, max_size=4))
    def is_told(self, atv: str, kinds: list[CommandKind]) -> None:
        """An operator presses buttons, in any order."""
        for kind in kinds:
            self.world.command(atv, kind)
            self.passes(0.5)

    def teardown(self) -> None:
        if not hasattr(self, "world") or self.world.broken:
            return
        world = self.world
        try:
            self.end_faults()
            done = world.run_until(lambda: world.fulfilled == {"O1"} and not world.open_tasks(), SETTLE_S)
            assert done, f"open: {world.open_tasks()}, fulfilled: {sorted(world.fulfilled)}"
            world.check_sums({"O1": self.quantity})
        finally:
            note("\n".join(world.log[-SHOWN:]))

    def end_faults(self) -> None:
        """All faults end."""
        world = self.world
        world.network.heal()
        for agent, actor in world.actors.items():
            if actor.leaving and world.is_up(agent):
                world.crash(agent)
            if not world.is_up(agent):
                world.start(agent)
        for atv in VEHICLES:
            world.repair(atv)
            world.notice_link(atv, Link.WLAN)
        world.failing.clear()
        world.run(world.now_s + 10.0)
        for kind in (CommandKind.ACKNOWLEDGE, CommandKind.RESUME):
            for atv, vehicle in world.vehicles.items():
                if vehicle.held:
                    world.command(atv, kind)
            world.run(world.now_s + 1.0)


TestAdversary = Adversary.TestCase
TestAdversary.settings = settings(max_examples=examples(60), stateful_step_count=20)
