import { describe, expect, test } from "vitest";
import { type Command, hear, isUnderway, type Stage, type Word } from "./life";

const sent: Command = {
  id: "1", atv: "ATV3", kind: "stop", speedFrac: null, by: "North", stage: "sent", reason: "", atS: 100,
};
const after = (...words: Word[]): Command => words.reduce((command, word, i) => hear(command, word, 101 + i, word), sent);

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
      expect(hear(over, second, 200)).toBe(over);
    },
  );

  test.each<[Stage, boolean]>([
    ["sent", true], ["accepted", true], ["confirmed", false], ["refused", false], ["not_confirmed", false],
  ])("%s is underway: %s", (stage, underway) => {
    expect(isUnderway({ stage })).toBe(underway);
  });
});
