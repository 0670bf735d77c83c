import { describe, expect, test } from "vitest";
import type { CommandView } from "../../api/types";
import { afterWord, type Command, fromPlant, isUnderway, type Stage, stagesOf, type Word } from "./life";

const sent: Command = {
  id: "1", atv: "ATV3", kind: "stop", speedFrac: null, by: "North", stage: "sent", accepted: false, reason: "", detail: "", atS: 100,
};
const after = (...words: Word[]): Command => words.reduce((command, word, i) => afterWord(command, word, 101 + i, { reason: word, detail: "" }), sent);

describe("a command", () => {
  test("is sent, accepted and confirmed", () => {
    expect(after("passed_on").stage).toBe("accepted");
    expect(after("passed_on", "done")).toMatchObject({ stage: "confirmed", atS: 102 });
  });

  test("is confirmed also where the vehicle's word overtakes the plant's", () => {
    expect(after("done", "passed_on")).toMatchObject({ stage: "confirmed", atS: 101 });
  });

  test("is refused with a reason", () => {
    expect(after("passed_on", "declined")).toMatchObject({ stage: "refused", reason: "declined" });
  });

  test("that nobody answered is not confirmed, until a late word comes", () => {
    expect(after("silence").stage).toBe("not_confirmed");
    expect(after("silence", "passed_on").stage).toBe("not_confirmed");
    expect(after("silence", "done").stage).toBe("confirmed");
    expect(after("silence", "declined").stage).toBe("refused");
  });

  test.each<[Word, Word]>([["done", "declined"], ["done", "silence"], ["declined", "done"], ["declined", "silence"]])(
    "that was %s is over: %s changes nothing",
    (first, second) => {
      const over = after(first);
      expect(afterWord(over, second, 200)).toBe(over);
    },
  );

  test("of another page is known by what the plant tells", () => {
    const view = { id: "2", atv: "ATV4", kind: "set_speed", speed_frac: 0.5, by: "South", at_s: 90, reason: "", detail: "", text: "" } as const;
    expect(fromPlant({ ...view, state: "sent" }, undefined)).toMatchObject({
      id: "2", atv: "ATV4", speedFrac: 0.5, by: "South", stage: "accepted", atS: 90,
    });
  });

  test("of this page goes by whatever is heard first, the answer or the stream", () => {
    const view = { id: "1", atv: "ATV3", kind: "stop", speed_frac: null, by: "North", at_s: 90, reason: "not_here", detail: "", text: "" } as const;
    const told = (state: CommandView["state"], own: Command) => fromPlant({ ...view, state }, own);
    expect(told("sent", sent)).toMatchObject({ stage: "accepted", atS: 100 });
    expect(told("refused", sent)).toMatchObject({ stage: "refused", reason: "not_here" });
    expect(told("confirmed", after("silence")).stage).toBe("confirmed");
    expect(told("sent", after("done")).stage).toBe("confirmed");
  });

  test.each<[Word[], Stage[]]>([
    [[], ["sent"]],
    [["passed_on"], ["sent", "accepted"]],
    [["done"], ["sent", "accepted", "confirmed"]],
    [["silence"], ["sent", "accepted", "not_confirmed"]],
    [["declined"], ["sent", "accepted", "refused"]],
    // What nobody has said is not shown.
    [["rejected"], ["sent", "refused"]],
    [["unanswered"], ["sent", "not_confirmed"]],
    [["unsent"], ["not_sent"]],
    [["unanswered", "passed_on"], ["sent", "accepted", "not_confirmed"]],
  ])("after %j is shown as %j", (words, stages) => {
    expect(stagesOf(after(...words))).toEqual(stages);
  });

  test("that could not be sent has come through all the same when the plant tells of it", () => {
    expect(after("unsent", "passed_on").stage).toBe("accepted");
    expect(after("unsent", "done").stage).toBe("confirmed");
    expect(after("passed_on", "unsent").stage).toBe("not_confirmed");
    expect(after("unsent", "unsent")).toEqual(after("unsent"));
  });

  test.each<[Stage, boolean]>([
    ["sent", true], ["accepted", true], ["confirmed", false], ["refused", false], ["not_confirmed", false],
    ["not_sent", false],
  ])("%s is underway: %s", (stage, underway) => {
    expect(isUnderway({ stage })).toBe(underway);
  });
});
