import { batch, effect, signal } from "@preact/signals";
import { afterEach, beforeEach, describe, expect, test, vi } from "vitest";
import { refreshing } from "./refreshed";

const EVERY_MS = 5000;

/** A view that asks, and how its questions are answered, in the order in which they were asked. */
function view() {
  const [answer, failed, turn] = [signal<string | null>(null), signal<string | null>(null), signal(0)];
  const about = signal("orders");
  const open: { readonly about: string; answer: (found: string) => void; fail: (why: string) => void }[] = [];
  const ask = (): Promise<string> => {
    const said = about.value;
    return new Promise((answerIt, failIt) => open.push({ about: said, answer: answerIt, fail: failIt }));
  };
  const told = { answer, failed, turn };
  const asking = { current: ask };
  const leave = effect(() => refreshing(asking, EVERY_MS, told));
  const render = (what: string): void => {
    asking.current = () => {
      void about.toString();
      return new Promise((answerIt, failIt) => open.push({ about: what, answer: answerIt, fail: failIt }));
    };
  };
  return { about, answer, failed, leave, open, render, turn };
}

const passed = async (ms = 0): Promise<void> => { await vi.advanceTimersByTimeAsync(ms); };

describe("an answer that is asked for again and again", () => {
  beforeEach(() => { vi.useFakeTimers(); });
  afterEach(() => { vi.useRealTimers(); });

  test("stays while a later question has none, and says why", async () => {
    const { answer, failed, leave, open } = view();
    open[0]?.answer("three");
    await passed();
    await passed(EVERY_MS);
    open[1]?.fail("gone");
    await passed();
    expect([answer.value, failed.value, open.length]).toEqual(["three", "gone", 2]);
    await passed(EVERY_MS);
    open[2]?.answer("four");
    await passed();
    expect([answer.value, failed.value]).toEqual(["four", null]);
    leave();
    await passed(EVERY_MS);
    expect(open).toHaveLength(3);
  });

  test("of a question that nobody asks any more says nothing, whichever way it comes", async () => {
    const { about, answer, failed, open } = view();
    about.value = "tasks";
    expect(open.map((each) => each.about)).toEqual(["orders", "tasks"]);
    open[1]?.answer("tasks");
    await passed();
    open[0]?.fail("refused");
    await passed();
    expect([answer.value, failed.value]).toEqual(["tasks", null]);
  });

  test("of a question that nobody asks any more does not hide why the one that is asked has none", async () => {
    const { answer, failed, open, turn } = view();
    turn.value++;
    open[1]?.fail("refused");
    await passed();
    open[0]?.answer("late");
    await passed();
    expect([answer.value, failed.value]).toEqual([null, "refused"]);
  });

  test("does not have the fault of the question before it, unless that was the same", async () => {
    const { about, failed, open, turn } = view();
    open[0]?.fail("refused");
    await passed();
    turn.value++;
    expect([failed.value, open.length]).toEqual(["refused", 2]);
    about.value = "tasks";
    expect(failed.value).toBeNull();
  });

  test.each(["the question", "the turn"])("does not have the fault of the question before it when both change at once, %s first", async (first) => {
    const { about, failed, open, turn } = view();
    open[0]?.fail("refused");
    await passed();
    const changes = [() => { about.value = "tasks"; }, () => { turn.value++; }];
    batch(() => { for (const change of first === "the turn" ? changes.reverse() : changes) change(); });
    expect([failed.value, open.at(-1)?.about]).toEqual([null, "tasks"]);
  });

  test("is asked for as the view asks now, and not as it did when it was shown first", async () => {
    const { answer, open, render, turn } = view();
    render("orders of today");
    turn.value++;
    expect(open.map((each) => each.about)).toEqual(["orders", "orders of today"]);
    open[1]?.answer("two");
    await passed();
    expect(answer.value).toBe("two");
    render("orders of tomorrow");
    await passed(EVERY_MS);
    expect(open.at(-1)?.about).toBe("orders of tomorrow");
  });

  test("is asked for at each turn, and only what the last one finds is shown", async () => {
    const { answer, open, turn } = view();
    turn.value++;
    turn.value++;
    expect(open.map((each) => each.about)).toEqual(["orders", "orders", "orders"]);
    open[2]?.answer("three");
    open[0]?.answer("one");
    await passed();
    expect(answer.value).toBe("three");
  });
});
