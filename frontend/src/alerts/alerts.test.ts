import { describe, expect, test } from "vitest";
import type { AlertView, CauseView } from "../api/types";
import { asksText, whatText } from "./alert-text";
import { chosenOf, countsOf, inOrder, isOfPlant } from "./alerts";

const cause = (more: Partial<CauseView>): CauseView => ({ reason: "", detail: "", machines: [], lacks: [], not_made: [], handover: null, wait: null, clock_ahead_s: 0, times: 1, text: "", ...more });

const alert = (more: Partial<AlertView>): AlertView => ({
  id: `${more.kind ?? "machine_error"}-${more.agent ?? "M8"}`, kind: "machine_error", level: "alarm", response: "repair",
  since_at_s: 100, agent: "M8", task: "", order: "", place: "", agents: [], call: null, keepers: [], cause: null, goods: null, doubt: null, by: "", seen_at_s: null, access_point: "", until_at_s: null,
  battery_frac: null, behind_s: null, clock_ahead_s: null, waiting: null, carried_frac: null,
  acknowledged_by: "", acknowledged_at_s: null, acknowledged_until_at_s: null, came_back: null, comment: "", comment_by: "", ...more,
});

describe("alerts", () => {
  test("that somebody has taken on are counted until they end", () => {
    const [open, taken] = [alert({ agent: "M1" }), alert({ agent: "M2", acknowledged_by: "Day shift" })];
    const warning = alert({ agent: "M3", level: "warning", acknowledged_by: "Day shift" });
    expect(countsOf([open, taken, warning])).toEqual({ alarms: 1, alarmsTaken: 1, warnings: 0, warningsTaken: 1 });
    expect(countsOf([])).toEqual({ alarms: 0, alarmsTaken: 0, warnings: 0, warningsTaken: 0 });
  });

  test("are in the order in which they are answered", () => {
    const taken = alert({ agent: "M1", acknowledged_by: "Day shift" });
    const warning = alert({ agent: "M2", level: "warning", since_at_s: 900 });
    const old = alert({ agent: "M3", since_at_s: 10 });
    const fresh = alert({ agent: "M4", since_at_s: 20 });
    expect(inOrder([taken, warning, old, fresh]).map(({ agent }) => agent)).toEqual(["M4", "M3", "M2", "M1"]);
  });

  test("name who grants no places before an awaited vehicle has told", () => {
    const awaited = alert({ kind: "atv_awaited", agent: "ATV7", keepers: ["M3", "M4"], response: "switch_on" });
    expect(whatText(awaited, 100, 1)).toMatch(/^Not heard, and M3, M4 grant no place/);
    expect(asksText(awaited)).toBe("Switch it on; or say that it is off the floor");
  });

  test("lead to what they are about", () => {
    const atvs = new Map([["ATV3", {}]]);
    expect(chosenOf(alert({}), atvs)).toEqual({ kind: "machine", id: "M8" });
    expect(chosenOf(alert({ kind: "atv_lost", agent: "ATV3" }), atvs)).toEqual({ kind: "atv", id: "ATV3" });
    expect(chosenOf(alert({ kind: "station_lost", agent: "S1" }), atvs)).toEqual({ kind: "machine", id: "S1" });
    expect(chosenOf(alert({ kind: "clock_wrong", agent: "ATV3" }), atvs)).toEqual({ kind: "atv", id: "ATV3" });
    expect(chosenOf(alert({ kind: "clock_wrong", agent: "M8" }), atvs)).toEqual({ kind: "machine", id: "M8" });
    expect(chosenOf(alert({ kind: "task_trouble", agent: "ATV3", task: "T1" }), atvs)).toEqual({ kind: "task", id: "T1" });
    expect(chosenOf(alert({ kind: "order_late", agent: "", order: "O-1" }), atvs)).toBeNull();
    expect(chosenOf(alert({ kind: "plant_behind", agent: "" }), atvs)).toBeNull();
    expect([isOfPlant(alert({ kind: "overloaded", agent: "" })), isOfPlant(alert({}))]).toEqual([true, false]);
  });
});

describe("an alert says", () => {
  const said = (more: Partial<AlertView>, speed = 1): string => whatText(alert(more), 100, speed).replaceAll("\u202f", " ");

  test("what is wrong, in the agent's own words too", () => {
    expect(said({ cause: cause({ detail: "spindle" }) })).toBe("Stopped by a fault: spindle");
  });

  test("which goods are left on board, for which order, until when, and who comes", () => {
    const goods = { item: "pump-p3", name: "Pump P3", quantity: 24, machine: "M8", order_name: "PO 4711", node: "c3", handed_at: "" };
    const left = { kind: "goods_stranded", agent: "ATV2", task: "M8-7", goods, until_at_s: 700 } as const;
    expect(said(left)).toMatch(/^Has 24 × Pump P3 for PO 4711 on board and does not go on; kept until .*, then made again$/);
    expect(said({ ...left, cause: cause({ reason: "silent" }) })).toMatch(/does not go on: silent; kept/);
    expect(said({ ...left, call: "call_nobody" })).toMatch(/; nobody is on duty there$/);
    expect(said({ ...left, goods: { ...goods, handed_at: "c4" } })).toContain("another vehicle fetches them at c4");
    expect(said({ ...left, goods: { ...goods, order_name: "" } })).toContain("for –");
    expect(chosenOf(alert(left), new Map())).toEqual({ kind: "task", id: "M8-7" });
  });

  test("where a thing without master data was to go that is left on board", () => {
    const goods = { item: ".thing", name: ".thing", quantity: 1, machine: "S3", order_name: "", node: "c3", handed_at: "" };
    const left = { kind: "goods_stranded", agent: "ATV2", task: "T-9-1", goods, until_at_s: 700 } as const;
    expect(said(left)).toMatch(/^Has a thing for S3 on board and does not go on; waited for until .*, then looked for where it was fetched$/);
    expect(said({ ...left, goods: { ...goods, handed_at: "c4" } })).toContain("A thing for S3: another vehicle fetches it at c4");
  });

  test("why nobody comes, after what is wrong", () => {
    const called = alert({ cause: cause({ detail: "spindle" }), call: "call_nobody", response: "send_somebody" });
    expect(whatText(called, 100, 1)).toBe("Stopped by a fault: spindle; nobody is on duty there");
    expect(said({ kind: "atv_help", until_at_s: 142, call: "call_unanswered" })).toBe("Needs help within 42 s; nobody has taken the call");
  });

  test("what many have lost, and who", () => {
    const agents = ["ATV1", "ATV4", "M8"];
    const part = alert({ kind: "part_lost", agent: "", agents, seen_at_s: 70, response: "look_at_part" });
    expect(whatText(part, 100, 1).replaceAll("\u202f", " ")).toBe("No heartbeat of ATV1, ATV4, M8 for 30 s; they fell silent at the same moment");
    expect([isOfPlant(part), asksText(part)]).toEqual([true, "See what they share: a part of the network, or power"]);
    expect(said({ kind: "access_point", agent: "", agents: ["ATV1", "ATV4"], access_point: "AP3", seen_at_s: 70 })).toBe(
      "No WLAN at access point AP3, for 30 s: ATV1, ATV4 have lost it",
    );
  });

  test("for what a machine waits", () => {
    const waits = { kind: "machine_starved", cause: cause({ lacks: [{ material: "Rotor", short: ["S3"], silent: [] }] }) } as const;
    expect(said(waits)).toBe("Has waited long for material: Rotor (nothing in storage S3)");
  });

  test("what was said that is not believed, and how often", () => {
    expect(said({ kind: "handover_disputed", cause: cause({ handover: { said: 20, item: "shaft", where: "M1", counted: 0 }, times: 2 }) })).toBe(
      "Says that loads are down which were not counted: says 20 \u00d7 shaft to M1, 0 counted (2 times)",
    );
    expect(said({ kind: "word_disbelieved", cause: cause({ reason: "negative" }) })).toBe(
      "Says what cannot be: a bid with a negative part",
    );
    expect(said({ kind: "word_disbelieved", cause: cause({ reason: "clock", clock_ahead_s: -400 }) })).toBe("Says what cannot be: Its clock is 6:40 min behind");
    expect(said({ kind: "word_disbelieved", cause: cause({ reason: "a_later_word", times: 2 }) })).toBe("Says what cannot be: a later word (2 times)");
  });

  test("for how long nothing was heard", () => {
    expect(said({ kind: "atv_lost", seen_at_s: 70 })).toBe("No heartbeat for 30 s");
    expect(said({ kind: "atv_mesh" })).toBe("No WLAN");
    const mesh = said({ kind: "atv_mesh", seen_at_s: 70, access_point: "AP3", agents: ["ATV1"] });
    expect(mesh).toBe("No WLAN, for 30 s, last at AP3, heard over ATV1");
    const station = alert({ kind: "station_lost", agent: "S1", response: "look_at_station", seen_at_s: 70 });
    expect(whatText(station, 100, 1).replaceAll("\u202f", " ")).toBe("No heartbeat of its station for 30 s: nobody is promised material from here");
    expect(asksText(station)).toContain("power and network");
    const dock = alert({ kind: "dock_not_ready", agent: "M8", agents: ["ATV2"], response: "see_to_dock", seen_at_s: 30 });
    expect(whatText(dock, 100, 1).replaceAll("\u202f", " ")).toBe("Its dock has not got ready for ATV2 for 70 s");
    const fails = alert({ kind: "dock_fails", agent: "M8", task: "M8-9", response: "see_to_dock" });
    expect([whatText(fails, 100, 1), asksText(fails)]).toEqual([
      "Vehicles fail to load or unload at the dock of M8",
      "Look at its dock",
    ]);
  });

  test("that nobody knows what lies in a storage, and that it is to be counted", () => {
    const unknown = alert({ kind: "stock_unknown", agent: "S3", response: "count_stock" });
    expect(whatText(unknown, 100, 1)).toContain("not known any more");
    expect(asksText(unknown)).toContain("Count what lies there");
  });

  test("which pieces perhaps lie at a place, and that they are to be counted", () => {
    const doubt = { load: "M5.2-load-1", vehicle: "ATV5", item: "pump-p3", name: "Pump P3", quantity: 10, brought: false };
    const asked = alert({ kind: "load_doubtful", agent: "M5", level: "warning", response: "count_stock", doubt });
    expect(whatText(asked, 100, 1)).toBe("10 × Pump P3 perhaps lie there, and are not in the stock: nobody can tell whether ATV5 took them");
    expect(whatText({ ...asked, doubt: { ...doubt, brought: true } }, 100, 1)).toContain("whether ATV5 put them down");
    expect(asksText(asked)).toContain("Count what lies there");
    expect(chosenOf(asked, new Map())).toEqual({ kind: "machine", id: "M5" });
  });

  test("how long help is waited for, in factory time", () => {
    expect(said({ kind: "atv_help", until_at_s: 142 })).toBe("Needs help within 42 s");
    expect(said({ kind: "atv_help", until_at_s: 110 }, 3)).toBe("Needs help within 30 s of factory time");
    expect(said({ kind: "atv_help", until_at_s: 90 })).toBe("Needs help, and the time for it is over");
    expect(said({ kind: "atv_promised", until_at_s: 90, by: "Shift 2" })).toBe("Shift 2 is on the way, expected within 0 s");
  });

  test("who has shut an agent out, and why", () => {
    const out = { by: "Maria", cause: cause({ detail: "does not move" }) };
    expect(said({ ...out, kind: "atv_shut_out" })).toBe("Shut out by Maria: does not move");
    expect(said({ ...out, kind: "machine_shut_out" })).toBe("Shut out by Maria: does not move");
    expect(said({ ...out, kind: "station_shut_out", agent: "S3" })).toBe("Shut out by Maria: does not move");
    expect(chosenOf(alert({ ...out, kind: "machine_shut_out", agent: "M8" }), new Map())).toEqual({ kind: "machine", id: "M8" });
  });

  test("of the plant as a whole how far it is behind, and how much is not carried", () => {
    expect(said({ kind: "plant_behind", agent: "", behind_s: 42 })).toBe(
      "What is shown is 42 s old: the simulation, the server or its network cannot keep up",
    );
    const overloaded = { kind: "overloaded", agent: "", waiting: 14 } as const;
    expect(said(overloaded)).toContain("14 transports have waited");
    expect(said({ ...overloaded, carried_frac: 0.61 })).toContain("61 %");
  });

  test("what it asks for", () => {
    expect(asksText(alert({}))).toBe("Have it repaired");
  });
});
