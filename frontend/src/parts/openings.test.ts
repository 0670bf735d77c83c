import { expect, test } from "vitest";
import { Openings } from "./openings";

function form(typed: string) {
  const at = { typed, complaint: "" };
  const openings = new Openings<string>({
    read: () => at.typed,
    write: (fields) => { Object.assign(at, { typed: fields, complaint: "" }); },
    complain: (error) => { at.complaint = String(error); },
    tell: (fields, error) => `${fields}: ${String(error)}`,
  });
  const begin = (other: string): void => {
    openings.begin();
    Object.assign(at, { typed: other, complaint: "" });
  };
  return { at, openings, begin };
}

// eslint-disable-next-line @typescript-eslint/only-throw-error -- what was thrown is told as it is
const refuse = (): never => { throw "too many"; };

test("a refusal of what is open is told in its form", async () => {
  const { at, openings } = form("Early");
  expect(await openings.send(async () => { await Promise.resolve(); refuse(); })).toBe(false);
  expect([at.complaint, openings.refused.value]).toEqual(["too many", []]);
});

test("a refusal of what is open no more is told beside the form, and restores all that was typed", async () => {
  const { at, begin, openings } = form("Early");
  await openings.send(async (isOpen) => {
    await Promise.resolve();
    at.typed = "Early, changed";
    begin("Late");
    begin("Later");
    expect(isOpen()).toBe(false);
    refuse();
  });
  expect(at).toEqual({ typed: "Later", complaint: "" });
  expect(openings.refused.value.map(({ text }) => text)).toEqual(["Early, changed: too many"]);
  openings.refused.value[0]?.restore();
  expect([at, openings.refused.value]).toEqual([{ typed: "Early, changed", complaint: "too many" }, []]);
});

test("the same thing opened once more is another opening", async () => {
  const { begin, openings } = form("Early");
  await openings.send(async (isOpen) => {
    await Promise.resolve();
    begin("Early");
    expect(isOpen()).toBe(false);
  });
});
