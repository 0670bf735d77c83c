"""What led to a violation is told, and nothing else."""

from __future__ import annotations

from check_kit import TASK, WORK, closed, event, heartbeat

from dray.messages import Reason, Release, Role, TaskAnnounced
from dray_sim.explore.story import Story


def test_a_story_goes_back_to_what_the_violation_names() -> None:
    story = Story()
    story.on_message(
        1.0, "M8", ">ATV2", Release(task=TASK, epoch=1, role=Role.PRIMARY, reason=Reason.NO_ANSWER)
    )
    story.note(2.0, "--- F1 begins: crashed (agent='ATV2')")
    for second in range(100):
        story.on_message(10.0 + second, "M2", "*", event("M2", closed(f"M2-{second}")))
        story.on_message(10.0 + second, "M2", "*", heartbeat("ATV2"))
    lines = story.tell("invariant 1 is broken at 200.000 s: M8-1 did not end")
    assert lines[0] == "    1.000 s  M8 to ATV2: Release task=M8-1 epoch=1 role=primary reason=no_answer"
    assert lines[1] == "    2.000 s  --- F1 begins: crashed (agent='ATV2')"
    assert lines[-1].startswith("  109.000 s  M2 notes TaskClosed task=M2-99")
    assert "M2-10 " not in "".join(lines)
    assert not any("Heartbeat" in line for line in lines)


def test_a_story_tells_an_announcement_once() -> None:
    story = Story()
    announced = TaskAnnounced(
        task=TASK, epoch=1, role=Role.PRIMARY, coordinator="M8", work=WORK, deadline_s=100.0
    )
    for cell in ("1-1", "1-2", "2-1"):
        story.on_message(1.0, "M8", f"plant/task/{cell}", announced)
    (line,) = story.tell("nothing")
    assert "40 x shaft to M8" in line
