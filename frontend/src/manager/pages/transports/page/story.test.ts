import { describe, expect, test } from "vitest";
import type { TaskStory, TransportAnswer, TransportStory } from "../../../../api/transports";
import { isTransport, namedIn, addressOfTransport, transportOf } from "../../../views";
import { attemptsOf, carriersOf, expectedS, lateS, spanOf, stateOf, stepsOf } from "./story";

const at = (atS: number): string => new Date(atS * 1000).toISOString();

const transport = (more: Partial<TransportAnswer>): TransportAnswer => ({
  id: "T-1M9K3X2A4-K7QM", status: "assigned", from: "S5", to: "M8", item: "bearing", thing: null, quantity: 40, priority: "normal", vehicle: null, vehicle_until: null,
  vehicle_waits: null, shortage: null, ability: null, called_by: "Button", created_at: at(1000), due_at: at(1900), not_before: null, cancel_at: null, ended_at: null, updated_at: at(1000),
  carrier: null, expected_at: null, task: null, wait: null, refused: null, ...more,
});

const leg = { carrier: "ATV1", since_at_s: 1010, aboard_at_s: null, until_at_s: null, replaced: "" };

const story = (...legs: (typeof leg | (Omit<typeof leg, "aboard_at_s"> & { aboard_at_s: number | null; until_at_s: number | null }))[]): TransportStory => ({
  attempts: [{ task: "T-1M9K3X2A4-K7QM-1", goal: "", item: "bearing", quantity: 40, source: "S5", destination: "M8", opened_at_s: 1001, closed_at_s: null, outcome: "", legs, thing: "" }],
  moments: [], is_whole: true, links: [],
});

describe("a plain transport's page", () => {
  test("tells who carries it last, and who did before", () => {
    expect(carriersOf(story())).toEqual({ last: "", before: [] });
    expect(carriersOf(story({ ...leg, carrier: "ATV3" }, leg))).toEqual({ last: "ATV1", before: ["ATV3"] });
  });

  test("is late by what is expected, or by now where that is later, and not once it is called off", () => {
    expect(lateS(transport({ expected_at: at(1950) }), 1500)).toBe(50);
    expect(lateS(transport({ expected_at: at(1950) }), 2000)).toBe(100);
    expect(lateS(transport({}), 1500)).toBe(0);
    expect(lateS(transport({ status: "delivered", ended_at: at(1901) }), 5000)).toBe(1);
    expect(lateS(transport({ status: "cancelled", ended_at: at(2000) }), 5000)).toBe(0);
  });

  test("has an axis from the call to what is due and expected", () => {
    const span = spanOf(transport({ expected_at: at(2000) }), story(), 1500);
    expect(span.fromS).toBe(1000);
    expect(span.toS).toBeGreaterThan(2000);
    expect(expectedS(transport({ expected_at: at(2000), ended_at: at(1800) }))).toBeNull();
    // Of one that has ended: to its end.
    expect(spanOf(transport({ ended_at: at(1500) }), story(), 1500).toS).toBe(1520);
  });

  test("draws each leg until it ends, or until now", () => {
    expect(attemptsOf(story(leg), 1100)[0]?.bars).toEqual([{ kind: "fetch", fromS: 1010, toS: 1100 }]);
  });
});

describe("an attempt is named after its transport", () => {
  test("in the first life of its destination and in a later one", () => {
    expect(transportOf("T-1M9K3X2A4-K7QM-1")).toBe("T-1M9K3X2A4-K7QM");
    expect(transportOf("T-1M9K3X2A4-K7QM.3-12")).toBe("T-1M9K3X2A4-K7QM");
  });

  test("and no other task is", () => {
    for (const other of ["M4-1", "M4.2-1", "O-1M9K3X2A4-K7QM-1.1", "T-1M9K3X2A4-K7QM", ""]) expect(transportOf(other)).toBe("");
    expect(isTransport("T-1M9K3X2A4-K7QM")).toBe(true);
    expect(isTransport("O-1M9K3X2A4-K7QM")).toBe(false);
  });

  test("and its page has an address", () => {
    expect(namedIn(addressOfTransport("T-1M9K3X2A4-K7QM"), "transports")).toBe("T-1M9K3X2A4-K7QM");
    expect(namedIn("#transports?q=T-1", "transports")).toBe("");
  });
});

describe("a task that is carried", () => {
  const of = (state: TaskStory["transport"]["state"], ...legs: Parameters<typeof story>): string =>
    stateOf({ attempts: story(...legs).attempts, transport: { state } as TaskStory["transport"] });

  test("is as far as its last carrier", () => {
    expect(of("bidding")).toBe("waiting");
    expect(of("contracted", leg)).toBe("assigned");
    expect(of("contracted", { ...leg, aboard_at_s: 1020 }, leg)).toBe("assigned");
    expect(of("contracted", leg, { ...leg, aboard_at_s: 1020 })).toBe("on_board");
    expect(of("delivered")).toBe("delivered");
    expect(of("withdrawn", leg)).toBe("cancelled");
  });
});

test("each step that has happened has its time, whoever has gone on since", () => {
  const leg = { until_at_s: null, replaced: "" };
  const story = (...legs: { carrier: string; since_at_s: number; aboard_at_s: number | null }[]) => ({ attempts: [{ legs: legs.map((each) => ({ ...leg, ...each })) }] }) as unknown as TransportStory;
  expect(stepsOf(story())).toEqual({ setOffS: null, aboardS: null });
  const first = { carrier: "ATV6", since_at_s: 10, aboard_at_s: null };
  expect(stepsOf(story(first))).toEqual({ setOffS: 10, aboardS: null });
  expect(stepsOf(story(first, { carrier: "ATV1", since_at_s: 20, aboard_at_s: 30 }, { carrier: "ATV2", since_at_s: 40, aboard_at_s: 45 }))).toEqual({ setOffS: 10, aboardS: 30 });
});

test("while it is given out anew nobody carries it, and who did before is told", () => {
  const attempts = [{ legs: [{ carrier: "ATV3" }] }, { legs: [] }] as unknown as TransportStory["attempts"];
  expect(carriersOf({ attempts })).toEqual({ last: "", before: ["ATV3"] });
});
