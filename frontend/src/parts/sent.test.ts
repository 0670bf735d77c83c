import { expect, test } from "vitest";
import { afterSent, fieldsAfterSent } from "./sent";

test("a field that was not touched since it was sent makes room, another keeps what stands in it", () => {
  expect(afterSent("brakes", "brakes", "")).toBe("");
  expect(afterSent("brakes", "wheel", "")).toBe("wheel");
});

test("each field of a form is looked at by itself", () => {
  const lines = ["one"];
  const sent = { name: "Early", pieces: "4", lines };
  expect(fieldsAfterSent(sent, { ...sent, pieces: "7" }, { name: "", pieces: "", lines: [] })).toEqual({ name: "", pieces: "7", lines: [] });
  expect(fieldsAfterSent(sent, { ...sent, lines: ["one", "two"] }, { name: "", pieces: "", lines: [] })).toEqual({ name: "", pieces: "", lines: ["one", "two"] });
});
