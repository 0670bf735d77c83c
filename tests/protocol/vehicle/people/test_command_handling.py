"""Whom a vehicle obeys: nothing without a grant, for it, for now, and for the place where it is."""

from __future__ import annotations

from defaults import PLANT
from effects import committed, facts, instructed, sent
from msgspec.structs import replace
from rigs import VehicleRig
from seals import granted, seal

from dray.body import Hold, LimitSpeed, Unhold
from dray.memory import WHOLE, AtvMemory
from dray.messages import CommandAnswered, CommandKind, CommandRefusal, VehicleCommand, signed_words
from dray.messages.fact import CommandObeyed, HelpPromised
from dray.messages.people.command import STOP_MARGIN_M
from dray.plant import Plant
from dray.protocol.people.granted_commands import COMMANDS_KEPT
from dray.protocol.runtime.events import Effect, Ignore, Received
from dray.protocol.vehicle.atv import Atv

STOP = VehicleCommand(command="C1", kind=CommandKind.STOP, issued_by="shift lead")
SLOW = VehicleCommand(command="C2", kind=CommandKind.SET_SPEED, speed_frac=0.5)


def standing(node: str = "p3") -> VehicleRig:
    """ATV1 on a node of the default plant."""
    rig = VehicleRig(node=node)
    rig.start()
    return rig


def at(x_m: float, y_m: float) -> VehicleRig:
    """ATV1 on a spot of its own."""
    rig = standing()
    rig.sense = lambda: replace(  # type: ignore[method-assign]
        VehicleRig.sense(rig), pose=replace(VehicleRig.sense(rig).pose, x_m=x_m, y_m=y_m)
    )
    rig.wake()
    return rig


def area_of(rig: VehicleRig) -> str:
    """Where it is."""
    spot = PLANT.nodes[rig.node]
    return PLANT.areas_at(spot.x_m, spot.y_m)[0]


def told(rig: VehicleRig, command: VehicleCommand, sender: str = "gateway") -> CommandAnswered:
    [answer] = sent(rig.on_message(sender, command), CommandAnswered, to=sender)
    return answer


def counted(effects: list[Effect]) -> list[str]:
    return [effect.reason for effect in effects if isinstance(effect, Ignore)]


def assert_refused(rig: VehicleRig, command: VehicleCommand, why: str) -> None:
    """It is refused, said to be, written down and counted, and nothing is done."""
    before = len(rig.all)
    answer = told(rig, command)
    effects = rig.all[before:]
    assert (answer.done, answer.reason) == (False, why)
    [fact] = facts(effects, CommandObeyed)
    assert (fact.done, fact.reason, fact.issued_by) == (False, why, command.issued_by)
    assert counted(effects) == [f"a refused command: {why}"]
    assert instructed(effects, Hold) == instructed(effects, LimitSpeed) == []


def test_a_bare_word_is_refused() -> None:
    assert_refused(standing(), STOP, CommandRefusal.NOT_GRANTED)


def test_a_granted_command_is_obeyed() -> None:
    rig = standing()
    assert told(rig, granted("ATV1", STOP)).done
    assert len(instructed(rig.all, Hold)) == 1


def test_a_vehicle_that_trusts_nobody_obeys_nobody() -> None:
    rig = standing()
    rig.agent = Atv("ATV1", PLANT, vehicle_type="light")
    rig.start()
    assert_refused(rig, granted("ATV1", STOP), CommandRefusal.NOT_TRUSTED)


def test_a_grant_for_another_vehicle_is_refused() -> None:
    assert_refused(standing(), granted("ATV2", STOP), CommandRefusal.NOT_TRUSTED)


def test_a_grant_counts_for_its_own_command_only() -> None:
    grant = granted("ATV1", STOP).grant
    for other in (
        replace(STOP, command="C9"),
        replace(STOP, kind=CommandKind.RESUME),
        replace(STOP, issued_by="somebody else"),
        replace(STOP, wait_s=5.0),
        replace(STOP, speed_frac=0.5),
    ):
        assert_refused(standing(), replace(other, grant=grant), CommandRefusal.NOT_TRUSTED)


def test_no_part_of_a_grant_can_be_changed() -> None:
    grant = granted("ATV1", STOP, areas=("AREA1",)).grant
    assert grant is not None
    for other in (
        replace(grant, person="somebody-else"),
        replace(grant, areas=("AREA1", "AREA2")),
        replace(grant, everywhere=True),
        replace(grant, valid_until_s=grant.valid_until_s + 1.0),
        replace(grant, signature=bytes(64)),
    ):
        assert_refused(standing(), replace(STOP, grant=other), CommandRefusal.NOT_TRUSTED)


def test_no_two_commands_have_the_same_words() -> None:
    grant = granted("ATV1", STOP, areas=("AREA1",)).grant
    assert grant is not None
    variants = [
        (atv, replace(command, command=name), replace(grant, areas=areas))
        for atv in ("ATV1", 'ATV1","C1')
        for command in (STOP, SLOW, replace(SLOW, speed_frac=None, wait_s=0.5))
        for name in ("C1", 'C1","stop')
        for areas in ((), ("AREA1",), ("AREA1", "AREA2"), ("AREA1,AREA2",))
    ]
    assert len({signed_words(*each) for each in variants}) == len(variants)


def test_a_whole_number_is_signed_as_it_comes_over_the_wire() -> None:
    grant = granted("ATV1", SLOW).grant
    assert grant is not None
    one = signed_words("ATV1", replace(SLOW, speed_frac=1), grant)
    assert one == signed_words("ATV1", replace(SLOW, speed_frac=1.0), grant)


def test_an_expired_grant_is_refused() -> None:
    rig = standing()
    command = granted("ATV1", STOP, valid_until_s=10.0)
    rig.now_s = 10.1
    assert_refused(rig, command, CommandRefusal.EXPIRED)


def test_a_grant_counts_until_it_expires() -> None:
    rig = standing()
    rig.now_s = 10.0
    assert told(rig, granted("ATV1", STOP, valid_until_s=10.0)).done


def test_an_expired_command_may_be_granted_anew() -> None:
    rig = standing()
    rig.now_s = 20.0
    told(rig, granted("ATV1", STOP, valid_until_s=10.0))
    assert told(rig, granted("ATV1", STOP, valid_until_s=30.0)).done


def test_a_grant_for_the_area_where_the_vehicle_is_counts() -> None:
    rig = standing()
    for command in (STOP, SLOW):
        assert told(rig, granted("ATV1", command, areas=(area_of(rig),))).done


def test_a_grant_for_other_areas_is_refused() -> None:
    others = tuple(area for area in PLANT.areas if area != area_of(standing()))
    assert_refused(standing(), granted("ATV1", STOP, areas=others), CommandRefusal.NOT_HERE)
    assert_refused(standing(), granted("ATV1", SLOW, areas=others), CommandRefusal.NOT_HERE)
    assert_refused(standing(), granted("ATV1", SLOW, areas=()), CommandRefusal.NOT_HERE)


def test_a_promise_needs_a_grant_like_everything_else() -> None:
    promise = VehicleCommand(command="C3", kind=CommandKind.PROMISE, wait_s=60.0)
    rig = standing()
    assert_refused(rig, promise, CommandRefusal.NOT_GRANTED)
    assert facts(rig.all, HelpPromised) == []


BORDER_Y_M = 26.0
"""AREA1 begins here, and AREA2 ends."""


def test_on_the_border_the_grants_of_both_areas_count() -> None:
    for area in ("AREA1", "AREA2"):
        assert told(at(30.0, BORDER_Y_M), granted("ATV1", SLOW, areas=(area,))).done


def test_a_vehicle_that_has_just_left_can_still_be_stopped_and_nothing_else() -> None:
    y_m = BORDER_Y_M + STOP_MARGIN_M - 0.1
    assert told(at(30.0, y_m), granted("ATV1", STOP, areas=("AREA2",))).done
    assert_refused(at(30.0, y_m), granted("ATV1", SLOW, areas=("AREA2",)), CommandRefusal.NOT_HERE)


def test_a_vehicle_that_is_well_away_cannot_be_stopped() -> None:
    y_m = BORDER_Y_M + STOP_MARGIN_M + 0.1
    assert_refused(at(30.0, y_m), granted("ATV1", STOP, areas=("AREA2",)), CommandRefusal.NOT_HERE)


def test_what_counts_is_where_the_vehicle_is_when_it_hears_the_command() -> None:
    rig = at(30.0, BORDER_Y_M - 10.0)
    body = replace(rig.sense(), pose=replace(rig.sense().pose, y_m=BORDER_Y_M + 10.0))
    effects = rig.agent.handle(Received("gateway", granted("ATV1", SLOW, areas=("AREA1",)), body), rig.now_s)
    [answer] = sent(effects, CommandAnswered)
    assert answer.done


def test_a_plant_without_areas_obeys_grants_for_everywhere_only() -> None:
    bare = Plant(replace(PLANT.file, areas=()))
    rig = standing()
    rig.agent = Atv(
        "ATV1", bare, vehicle_type="light", trusts=lambda words, signature: signature == seal(words)
    )
    rig.start()
    assert_refused(rig, granted("ATV1", STOP, areas=("AREA1",)), CommandRefusal.NOT_HERE)
    assert told(rig, granted("ATV1", replace(STOP, command="C9"))).done


def test_a_command_that_is_heard_again_is_answered_as_before_whoever_passes_it_on() -> None:
    rig = standing()
    stop = granted("ATV1", STOP)
    assert told(rig, stop).done
    assert told(rig, stop, sender="somebody").done
    assert len(facts(rig.all, CommandObeyed)) == len(instructed(rig.all, Hold)) == 1


def test_strangers_cannot_make_a_vehicle_forget_what_it_was_told() -> None:
    rig = standing()
    stop = granted("ATV1", STOP)
    for command in (
        stop,
        granted("ATV1", VehicleCommand(command="C2", kind=CommandKind.ACKNOWLEDGE)),
        granted("ATV1", VehicleCommand(command="C3", kind=CommandKind.RESUME)),
    ):
        assert told(rig, command).done
    for number in range(COMMANDS_KEPT + 1):
        told(rig, replace(STOP, command=f"S{number}"))
    assert told(rig, stop).done
    assert len(instructed(rig.all, Hold)) == 1, "it goes on"


def commands() -> tuple[VehicleCommand, ...]:
    """A stop, and the two acts that end it."""
    return (
        granted("ATV1", STOP, valid_until_s=30.0),
        granted("ATV1", VehicleCommand(command="C2", kind=CommandKind.ACKNOWLEDGE), valid_until_s=30.0),
        granted("ATV1", VehicleCommand(command="C3", kind=CommandKind.RESUME), valid_until_s=30.0),
    )


def test_a_late_copy_of_what_was_obeyed_is_answered_as_before_and_not_recorded_as_refused() -> None:
    rig = standing()
    stop = granted("ATV1", STOP, valid_until_s=10.0)
    assert told(rig, stop).done
    rig.now_s = 10.1
    assert told(rig, stop).done
    assert len(facts(rig.all, CommandObeyed)) == len(instructed(rig.all, Hold)) == 1


def reborn(rig: VehicleRig) -> VehicleRig:
    """The vehicle's next life, on the same body."""
    after = VehicleRig(node=rig.node)
    after.memory, after.now_s, after.held = committed(rig.all), rig.now_s, rig.held
    after.start()
    return after


def test_the_next_life_does_not_obey_again_what_was_obeyed() -> None:
    rig = standing()
    for command in commands():
        assert told(rig, command).done
    after = reborn(rig)
    assert told(after, commands()[0]).done
    assert instructed(after.all, Hold) == [], "it goes on"


def test_the_next_life_does_not_obey_what_was_refused() -> None:
    rig = standing()
    stop, acknowledge, resume = commands()
    assert told(rig, stop).done
    assert not told(rig, resume).done, "nobody has acknowledged it"
    assert told(rig, acknowledge).done
    rig.held = True
    after = reborn(rig)
    assert not told(after, resume).done
    assert instructed(after.all, Unhold) == []


def test_only_commands_that_could_be_obeyed_again_are_written_down() -> None:
    rig = standing()
    told(rig, granted("ATV1", STOP, valid_until_s=10.0))
    rig.now_s = 20.0
    told(rig, granted("ATV1", SLOW, valid_until_s=30.0))
    note = committed(rig.all)[WHOLE]
    assert isinstance(note, AtvMemory)
    assert [each.command for each in note.answered] == [SLOW.command]
