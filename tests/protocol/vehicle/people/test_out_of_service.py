"""A vehicle that a person has taken out of service takes no work, and gives back in order what others can do as well."""

from __future__ import annotations

from effects import facts, sent
from msgspec import UNSET
from rigs import VehicleRig
from seals import granted
from spoken import announcement, award
from watches import GOODS, beat, carrying, guard, newest, reborn

from dray.body import ProblemRaised
from dray.messages import (
    Accepted,
    Bid,
    CommandAnswered,
    CommandKind,
    CommandRefusal,
    Declined,
    DockOpened,
    OutOfService,
    Reason,
    Resigned,
    Role,
    Superseded,
    VehicleCommand,
)
from dray.messages.fact import TookOver
from dray.messages.people.command import OUT_MAX_S


def told(rig: VehicleRig, kind: CommandKind, **more: object) -> CommandAnswered:
    command = VehicleCommand(command=f"C{len(rig.all)}", kind=kind, issued_by="Maria", **more)  # type: ignore[arg-type]
    [answer] = sent(rig.on_message("gateway", granted("ATV1", command)), CommandAnswered)
    return answer


def standing() -> VehicleRig:
    rig = VehicleRig()
    rig.start()
    return rig


def test_it_says_so_with_who_why_and_until_when_and_takes_no_work() -> None:
    rig = standing()
    assert told(rig, CommandKind.TAKE_OUT, reason="brakes", wait_s=3600.0).done
    out = OutOfService(by="Maria", since_s=0.0, reason="brakes", back_s=3600.0)
    assert newest(rig).out_of_service == out
    assert sent(rig.on_message("M8", announcement()), Bid) == []
    for role in Role:
        effects = rig.on_message("M8", award(role=role, primary="ATV2"))
        assert (len(sent(effects, Declined)), sent(effects, Accepted)) == (1, [])


def test_it_is_put_into_service_by_a_word_and_by_nothing_else() -> None:
    rig = standing()
    assert told(rig, CommandKind.PUT_IN).reason is CommandRefusal.IN_SERVICE
    assert told(rig, CommandKind.TAKE_OUT, wait_s=10.0).done
    rig.run(100.0)
    assert newest(rig).out_of_service is not UNSET, "its time is what is expected, and ends nothing"
    assert told(rig, CommandKind.PUT_IN).done
    assert newest(rig).out_of_service is UNSET
    assert len(sent(rig.on_message("M8", announcement()), Bid)) == 1


def test_what_is_not_on_board_is_given_back_at_once_or_carried_first() -> None:
    rig = carrying()
    assert told(rig, CommandKind.TAKE_OUT).done
    [resigned] = sent(rig.all, Resigned, to="M8")
    assert (resigned.role, resigned.reason) == (Role.PRIMARY, Reason.OUT_OF_SERVICE)
    rig.on_message("M8", Superseded(task="M8-1", epoch=2))
    assert newest(rig).task is None
    rig = carrying()
    assert told(rig, CommandKind.TAKE_OUT, after_work=True).done
    assert sent(rig.all, Resigned) == []
    assert newest(rig).task is not None


def test_what_is_on_board_it_brings_to_its_end() -> None:
    rig = standing()
    rig.on_message("M8", award(work=GOODS))
    rig.arrive()
    rig.on_message("M8", DockOpened(task="M8-1", epoch=1, station="M8"))
    rig.picked()
    assert told(rig, CommandKind.TAKE_OUT).done
    assert sent(rig.all, Resigned) == []
    assert newest(rig).task is not None


def test_it_gives_its_watches_back_and_takes_nothing_over() -> None:
    rig = guard()
    assert told(rig, CommandKind.TAKE_OUT, after_work=True).done
    [resigned] = sent(rig.all, Resigned, to="M8")
    assert (resigned.role, resigned.reason) == (Role.SECONDARY, Reason.OUT_OF_SERVICE)
    beat(rig, 2)
    rig.run(60.0)
    assert facts(rig.all, TookOver) == []


def test_its_next_life_is_out_of_service_too_and_gives_back_what_the_last_one_had() -> None:
    rig = carrying()
    assert told(rig, CommandKind.TAKE_OUT, reason="brakes").done
    again = reborn(rig)
    out = newest(again).out_of_service
    assert out is not UNSET
    assert out.reason == "brakes"
    assert [each.reason for each in sent(again.all, Resigned)] == [Reason.OUT_OF_SERVICE]


def test_no_time_that_cannot_be_is_believed_and_a_second_word_corrects_the_first() -> None:
    rig = standing()
    for wait_s in (0.0, -1.0, OUT_MAX_S + 1.0, float("nan")):
        refused = told(rig, CommandKind.TAKE_OUT, wait_s=wait_s)
        assert refused.reason is CommandRefusal.WAIT_OUT_OF_RANGE
    assert newest(rig).out_of_service is UNSET
    assert told(rig, CommandKind.TAKE_OUT, reason="brakes").done
    rig.run(50.0)
    assert told(rig, CommandKind.TAKE_OUT, reason="a new motor", wait_s=600.0).done
    out = newest(rig).out_of_service
    assert out == OutOfService(by="Maria", since_s=0.0, reason="a new motor", back_s=rig.now_s + 600.0)


def test_one_that_stands_with_a_problem_gives_back_as_well() -> None:
    rig = carrying()
    rig.report(ProblemRaised(reason="it stands"))
    assert told(rig, CommandKind.TAKE_OUT).done
    assert [each.reason for each in sent(rig.all, Resigned, to="M8")] == [Reason.OUT_OF_SERVICE]
