import { afterEach, expect, test } from "vitest";
import { vehicleName, withNames } from "./elsewhere";
import { failureText } from "./failure";
import { de } from "./operator/de";
import { en } from "./operator/en";
import { es } from "./operator/es";
import { speak } from "./speech";

afterEach(() => { speak("en", en, "en-GB"); });

test("a vehicle that its reader may not see is words in every language", () => {
  const said = { en: "a vehicle elsewhere", de: "ein Fahrzeug anderswo", es: "un vehículo en otra parte" };
  for (const [language, table] of Object.entries({ en, de, es })) {
    speak(language as "en", table, language);
    expect(vehicleName("*")).toBe(said[language as "en"]);
    expect(withNames("waits for *, behind *.")).toBe(`waits for ${said[language as "en"]}, behind ${said[language as "en"]}.`);
  }
  expect(vehicleName("ATV3")).toBe("ATV3");
});

test("what a vehicle reports names nobody elsewhere, and keeps its own stars", () => {
  expect(failureText("* stands in the way")).toBe("a vehicle elsewhere stands in the way");
  expect(failureText("E*12 at 3*4, **")).toBe("E*12 at 3*4, **");
});
