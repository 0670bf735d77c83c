import { expect, test } from "vitest";
import { countries, regionName } from "./regions";

test("countries are told and ordered in the reader's language", () => {
  const all = countries("de");
  expect(all.find(({ code }) => code === "ES")?.name).toBe("Spanien");
  const names = all.map(({ name }) => name);
  expect(names.indexOf("Österreich")).toBeLessThan(names.indexOf("Peru"));
  expect(all.length).toBe(250);
});

test.each(["EU", "UN", "DD", "SU", "ZZ"])("%s is no country", (code) => {
  expect(countries("en").some((country) => country.code === code)).toBe(false);
});

test.each([["DE", "Alemania"], ["DE-BW", "Alemania (BW)"], ["FR-Zone A", "Francia (Zone A)"], ["", ""], ["de", "de"]])("the region %j is %j", (region, name) => {
  expect(regionName(region, "es")).toBe(name);
});
