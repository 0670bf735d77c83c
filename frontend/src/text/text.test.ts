import { readdirSync, readFileSync } from "node:fs";
import { describe, expect, test } from "vitest";
import type { Table } from "./catalogue";
import type { CauseView } from "../api/types";
import { causeText, failureText } from "./failure";
import { formatsFor } from "./format";
import { languageOf, localeFor } from "./language";
import { n, t, word } from "./manager";
import { de as managerDe } from "./manager/de";
import { en as managerEn } from "./manager/en";
import { es as managerEs } from "./manager/es";
import { de as operatorDe } from "./operator/de";
import { en as operatorEn } from "./operator/en";
import { es as operatorEs } from "./operator/es";
import { speak } from "./speech";
import { alerts as alertsDe } from "./views/alerts/de";
import { alerts as alertsEn } from "./views/alerts/en";
import { alerts as alertsEs } from "./views/alerts/es";
import { floor as floorDe } from "./views/floor/de";
import { floor as floorEn } from "./views/floor/en";
import { floor as floorEs } from "./views/floor/es";
import { guide as guideDe } from "./views/guide/de";
import { guide as guideEn } from "./views/guide/en";
import { guide as guideEs } from "./views/guide/es";
import { kept as keptDe } from "./views/kept/de";
import { kept as keptEn } from "./views/kept/en";
import { kept as keptEs } from "./views/kept/es";
import { order as orderDe } from "./views/order/de";
import { order as orderEn } from "./views/order/en";
import { order as orderEs } from "./views/order/es";
import { paper as paperDe } from "./views/paper/de";
import { paper as paperEn } from "./views/paper/en";
import { paper as paperEs } from "./views/paper/es";
import { people as peopleDe } from "./views/people/de";
import { people as peopleEn } from "./views/people/en";
import { people as peopleEs } from "./views/people/es";
import { products as productsDe } from "./views/products/de";
import { products as productsEn } from "./views/products/en";
import { products as productsEs } from "./views/products/es";
import { records as recordsDe } from "./views/records/de";
import { records as recordsEn } from "./views/records/en";
import { records as recordsEs } from "./views/records/es";
import { recurring as recurringDe } from "./views/recurring/de";
import { recurring as recurringEn } from "./views/recurring/en";
import { recurring as recurringEs } from "./views/recurring/es";
import { replay as replayDe } from "./views/replay/de";
import { replay as replayEn } from "./views/replay/en";
import { replay as replayEs } from "./views/replay/es";
import { rows as rowsDe } from "./views/rows/de";
import { rows as rowsEn } from "./views/rows/en";
import { rows as rowsEs } from "./views/rows/es";
import { transports as transportsDe } from "./views/transports/de";
import { transports as transportsEn } from "./views/transports/en";
import { transports as transportsEs } from "./views/transports/es";
import { scenario as scenarioDe } from "./views/scenario/de";
import { scenario as scenarioEn } from "./views/scenario/en";
import { scenario as scenarioEs } from "./views/scenario/es";

const format = formatsFor("en-GB", "UTC");
const de = formatsFor("de-DE", "UTC");
/** Figures and units are kept together by a narrow space that does not break. */
const plain = (text: string): string => text.replaceAll("\u202f", " ");

describe("formats", () => {
  test.each([
    [0, "0 s"], [71.4, "71 s"], [119, "119 s"], [120, "2:00 min"], [220, "3:40 min"], [7199, "119:59 min"],
    [7500, "2:05 h"], [-30, "−30 s"], [239.9 * 3600, "239:54 h"], [240 * 3600, "10 d"], [631960 * 3600, "26,332 d"],
  ])("a duration of %d s is %s", (seconds, text) => {
    expect(plain(format.duration(seconds))).toBe(text);
  });

  test.each([[0.44, "0.4 s"], [-1, "0.0 s"], [12.3, "12 s"], [180, "3:00 min"]])("an age of %d s is %s", (s, text) => {
    expect(plain(format.age(s))).toBe(text);
  });

  test("numbers follow the locale", () => {
    expect(plain(format.percent(0.974, 1))).toBe("97.4 %");
    expect(plain(de.percent(0.974, 1))).toBe("97,4 %");
    expect(de.count(12000)).toBe("12.000");
  });

  test("times are of a 24 hour clock", () => {
    expect(format.clock(Date.UTC(2026, 0, 1, 0, 5, 9) / 1000)).toBe("00:05:09");
  });

  test("a due time is as long as it must be", () => {
    const now = Date.UTC(2026, 4, 4, 8) / 1000;
    expect(format.due(now + 3600, now)).toBe("09:00");
    expect(format.due(now + 3 * 86400, now)).toMatch(/^Thu.*08:00$/);
    expect(format.due(now + 30 * 86400, now)).toMatch(/^3 Jun.*08:00$/);
    expect(format.due(now + 40 * 365 * 86400, now)).toMatch(/^24 Apr.* 2066.*08:00$/);
    expect(format.when(now - 2 * 365 * 86400, now)).toMatch(/^4 May.* 2024.*08:00$/);
  });
});

describe("moments", () => {
  test("of today tell their seconds, others their day", () => {
    const now = Date.UTC(2026, 4, 4, 8) / 1000;
    expect(format.when(now - 61, now)).toBe("07:58:59");
    expect(format.when(now - 86400, now)).toMatch(/^Sun.*08:00$/);
  });
});

describe("times on paper", () => {
  const from = Date.UTC(2026, 10, 30, 6) / 1000;

  test("name their day and year, once where that is the same at both ends", () => {
    expect(format.dated(from)).toMatch(/^Mon.* 30 Nov 2026,? 06:00$/);
    expect(format.span(from, from + 8 * 3600)).toMatch(/^Mon.* 30 Nov 2026,? 06:00\W*14:00$/);
    expect(format.span(from, from + 24 * 3600)).toMatch(/^Mon.* 30 Nov 2026,? 06:00.*Tue.* 1 Dec 2026,? 06:00$/);
    expect(de.span(from, from + 8 * 3600)).toMatch(/^Mo.* 30\. Nov\.? 2026,? 06:00.*14:00/);
  });
});

describe("texts", () => {
  test("are filled in, once per name", () => {
    expect(t("machine.level", { level: 3, capacity: 9 })).toBe("3 / 9");
  });

  test("follow the number", () => {
    expect(n("alerts.alarm", 1)).toBe("1 alarm");
    expect(n("alerts.alarm", 2)).toBe("2 alarms");
  });

  const cause = (more: Partial<CauseView>): CauseView => ({ reason: "", detail: "", machines: [], lacks: [], not_made: [], handover: null, wait: null, clock_ahead_s: 0, times: 1, text: "", ...more });

  test("know what agents say of what is wrong, one or several of them", () => {
    speak("de", managerDe, "de-DE");
    expect(failureText("the load has shifted")).toBe("die Ladung ist verrutscht");
    expect(failureText("cannot carry a pallet")).toBe("Ladung der Art pallet");
    expect(failureText("12% would be left, 20% are needed")).toBe("12\u00a0% blieben übrig, 20\u00a0% sind nötig");
    expect(failureText("31 s too late")).toBe("31\u00a0s zu spät");
    const machines = [{ agent: "M1", reason: "silent" }, { agent: "M2", reason: "broken" }];
    expect(causeText(cause({ machines }))).toBe("M1 ist stumm, M2 ist ausgefallen");
    expect(causeText(cause({ not_made: ["P8", "P9"] }))).toBe("dieses Werk fertigt P8, P9 nicht");
    speak("en", managerEn, "en-GB");
    expect(causeText(cause({ machines: machines.slice(0, 1) }))).toBe("M1 is silent");
    expect(causeText(cause({ reason: "problem", detail: "the bridge is up" }))).toBe("the bridge is up");
    expect(causeText(cause({ reason: "dock_held", detail: "no room" }))).toBe("waited too long at the source; no room");
  });

  test.each([
    [
      "its count is in doubt (1796032800): pieces went from 70 to 9,000: 3 pieces at most can have been let in since",
      "seine Zählung ist zweifelhaft (Nummer 1796032800): pieces sprang von 70 auf 9.000: höchstens 3 Stück können seither eingelassen worden sein",
    ],
    ["its controller has no value for goal: 'A_7' is no label", "seine Steuerung hat keinen Wert für goal ('A_7' ist kein Etikett)"],
    ["its controller is not heard: opc.tcp://m8.plant:4840: it does not answer", "seine Steuerung ist nicht zu hören (opc.tcp://m8.plant:4840: sie antwortet nicht)"],
    ["its controller has a fault: fault 17", "seine Steuerung hat eine Störung: Störung 17"],
    ["fault 17", "Störung 17"],
    ["must charge: 28% left, takes work again from 40% on", "muss laden: noch 28\u00a0%, nimmt ab 40\u00a0% wieder Arbeit an"],
    ["it has not come nearer to m8 for 65 s: it stands, and does not say why", "es ist m8 seit 65\u00a0s nicht näher gekommen: es steht, und sagt nicht warum"],
    [
      "it has not come nearer to m8 for 65 s: it stands; it reports: motorFault: axis 2",
      "es ist m8 seit 65\u00a0s nicht näher gekommen: es steht; es meldet: motorFault: axis 2",
    ],
    ["its action pick has not ended for 300 s: its status is COMPLETED", "seine Aktion pick endet seit 300\u00a0s nicht: sie steht auf COMPLETED"],
    ["its mode is MANUAL", "seine Betriebsart ist MANUAL"],
    ["it does not pause: it moves although it was told to stand", "es hält nicht an: es bewegt sich, obwohl es stehen soll"],
    ["it has refused 2 orders one after the other: it does not say why", "es hat 2 Fahraufträge nacheinander abgewiesen: es sagt nicht warum"],
    ["it takes no order: its action pick is RUNNING, of an earlier order", "es nimmt keinen Fahrauftrag an: seine Aktion pick steht auf RUNNING, aus einem früheren Fahrauftrag"],
    [
      "tells that nothing is on board, and 4 shaft should be: see to it, then MANUAL and back",
      "meldet an Bord: nichts; es sollte sein: 4 shaft. Nachsehen, dann auf MANUAL und zurück schalten",
    ],
    ["AXIS_3_LIMIT", "AXIS_3_LIMIT"],
    ["its controller has a fault: AXIS_3_LIMIT", "seine Steuerung hat eine Störung: AXIS_3_LIMIT"],
  ])("tell in the reader's language what a controller's problem is, and in the controller's what it says: %s", (said, text) => {
    speak("de", managerDe, "de-DE");
    expect(failureText(said)).toBe(text);
    speak("en", managerEn, "en-GB");
  });

  test.each([
    [["S3"], [], "Rotor (nothing in storage S3)"],
    [["S3", "S4"], ["S5"], "Rotor (nothing in storage S3, S4, no answer from storage S5)"],
    [[], [], "Rotor"],
  ])("tell which storages have none and which do not answer", (short, silent, text) => {
    expect(causeText(cause({ lacks: [{ material: "Rotor", short, silent }] }))).toBe(text);
  });

  test("tell every reason of the wire that is shown, in every language", () => {
    const reasons = Object.keys(managerEn).filter((key) => key.startsWith("reason.why."));
    expect(reasons.length).toBeGreaterThan(30);
    for (const table of [managerDe, managerEs] as Table[]) for (const reason of reasons) expect(table[reason]).toBeTruthy();
  });

  test("leave a word of a newer server readable", () => {
    expect(word("reason", "battery")).toBe("battery");
    expect(word("reason", "too_heavy")).toBe("too heavy");
  });

  test("change with the language", () => {
    speak("de", managerDe, "de-DE");
    expect(n("alerts.alarm", 2)).toBe("2 Alarme");
    speak("en", managerEn, "en-GB");
    expect(n("alerts.alarm", 2)).toBe("2 alarms");
  });
});

test.each([["en", operatorEn], ["de", operatorDe], ["es", operatorEs]])("a person off duty and a vehicle out of service are not the same word in %s", (_language, words) => {
  expect(words["duty.off"].toLowerCase()).not.toBe(words["command.take_out"].toLowerCase());
});

describe("one word for each thing", () => {
  /** Keys of the texts in this language that have a word, in all files. */
  const keysWith = (language: string, found: RegExp): string[] => {
    const files = readdirSync(new URL(".", import.meta.url), { recursive: true, encoding: "utf8" });
    const own = files.filter((file) => file.endsWith(`/${language}.ts`) || file.includes(`/${language}/`));
    const lines = own.flatMap((file) => readFileSync(new URL(file, import.meta.url), "utf8").split("\n"));
    return lines.flatMap((line) => {
      const [, key = "", said = ""] = /^\s*"([^"]+)": "(.*)"/.exec(line) ?? [];
      return found.test(said) ? [key] : [];
    });
  };

  test("in German a goal is a Fertigungsauftrag, a target a Vorgabe, and only a destination a Ziel", () => {
    expect(keysWith("de", /Fertigungsauftr/).length).toBeGreaterThan(20);
    expect(keysWith("de", /Ziel(e|en|s)?\b/).sort()).toEqual(["called.refused.not_kept_here", "reason.why.not_counted"]);
  });

  test("in Spanish a goal is an orden de fabricación, and only a target an objetivo", () => {
    expect(keysWith("es", /[oó]rden(es)? de fabricación/i).length).toBeGreaterThan(20);
    const targets = keysWith("es", /objetivo|\bmetas?\b/i);
    expect(targets.filter((key) => !/^(shift|targets|audit)\./.test(key))).toEqual([]);
  });

  test.each([["de", managerDe], ["es", managerEs]])("in %s the list of all tasks is not called one of transports", (_language, words) => {
    expect(words["nav.tasks"]).not.toMatch(/^Transporte/);
  });
});

describe("a page's language", () => {
  test.each([
    ["dray_language=es", ["de-DE"], "es"],
    ["theme=dark; dray_language=de; more=1", [], "de"],
    ["dray_language=fr", ["fr-FR", "de-AT", "en"], "de"],
    ["", ["fr-FR"], "en"],
  ])("with the cookies %j and the wishes %j is %s", (cookies, wanted, language) => {
    expect(languageOf(cookies, wanted)).toBe(language);
  });

  test("keeps the numbers and dates of the region", () => {
    expect(localeFor("de", ["en-US", "de-AT"])).toBe("de-AT");
    expect(localeFor("en", ["en"])).toBe("en-GB");
  });
});

describe.each<[string, Table, Record<string, Table>]>([
  ["the management panel", managerEn, { de: managerDe, es: managerEs }],
  ["the operator panel", operatorEn, { de: operatorDe, es: operatorEs }],
  ["alerts", alertsEn, { de: alertsDe, es: alertsEs }],
  ["floor", floorEn, { de: floorDe, es: floorEs }],
  ["guide", guideEn, { de: guideDe, es: guideEs }],
  ["what is kept", keptEn, { de: keptDe, es: keptEs }],
  ["order", orderEn, { de: orderDe, es: orderEs }],
  ["paper", paperEn, { de: paperDe, es: paperEs }],
  ["products", productsEn, { de: productsDe, es: productsEs }],
  ["records", recordsEn, { de: recordsDe, es: recordsEs }],
  ["recurring", recurringEn, { de: recurringDe, es: recurringEs }],
  ["replay", replayEn, { de: replayDe, es: replayEs }],
  ["people and keys", peopleEn, { de: peopleDe, es: peopleEs }],
  ["rows of spreadsheets", rowsEn, { de: rowsDe, es: rowsEs }],
  ["scenario", scenarioEn, { de: scenarioDe, es: scenarioEs }],
  ["plain transports", transportsEn, { de: transportsDe, es: transportsEs }],
])("the texts of %s", (_, en, others) => {
  test("have both forms wherever they count", () => {
    for (const key of Object.keys(en)) if (key.endsWith(".other")) expect(en).toHaveProperty([key.replace(/other$/, "one")]);
  });

  test.each(Object.keys(others))("are whole in %s, with the same names to fill in", (language) => {
    const namesOf = (message = ""): string[] => [...new Set(message.match(/\{\w+\}/g))].sort();
    const other = others[language] ?? {};
    expect(Object.keys(other).sort()).toEqual(Object.keys(en).sort());
    for (const [key, message] of Object.entries(en)) expect(namesOf(other[key]), key).toEqual(namesOf(message));
  });
});
