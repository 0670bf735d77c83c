import { effect } from "@preact/signals";
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { fetchDefinitions } from "../api/products";
import { formerName, PAUSE_MS } from "./former";

vi.mock("../api/products", () => ({ fetchDefinitions: vi.fn() }));

const asked = vi.mocked(fetchDefinitions);
const offline = new TypeError("Failed to fetch");
const removed = (...ids: string[]) => ids.map((id) => ({ id, by: "maria", name: `${id} of steel`, revision: 1, at_s: 0, state: "removed" as const }));

/** All that was begun is done, as far as no time has to pass for it. */
const settled = async (): Promise<void> => {
  await vi.advanceTimersByTimeAsync(0);
  await vi.dynamicImportSettled();
  await vi.advanceTimersByTimeAsync(0);
};

beforeEach(() => { vi.useFakeTimers(); });
afterEach(() => {
  asked.mockReset();
  vi.useRealTimers();
});

test("many names are asked for once, and those that nobody knows not again", async () => {
  asked.mockResolvedValue(removed("plate"));
  for (const id of ["plate", "nothing", "plate"]) expect(formerName(id)).toBe(id);
  await settled();
  expect([formerName("plate"), formerName("nothing")]).toEqual(["plate of steel", "nothing"]);
  await settled();
  expect(asked).toHaveBeenCalledTimes(1);
});

test("after an answer that failed it is asked again when a name is wanted, but not before a pause is over", async () => {
  asked.mockRejectedValueOnce(offline).mockResolvedValue(removed("bracket"));
  formerName("bracket");
  await settled();
  for (const id of ["bracket", "flange", "bracket"]) {
    expect(formerName(id)).toBe(id);
    await settled();
  }
  await vi.advanceTimersByTimeAsync(PAUSE_MS);
  await settled();
  expect(asked).toHaveBeenCalledTimes(1);
  formerName("bracket");
  await settled();
  expect(formerName("bracket")).toBe("bracket of steel");
  expect(asked).toHaveBeenCalledTimes(2);
});

test("what shows an id meanwhile wants its name again by itself", async () => {
  asked.mockRejectedValueOnce(offline).mockRejectedValueOnce(offline).mockResolvedValue(removed("shaft"));
  const shown: string[] = [];
  const leave = effect(() => { shown.push(formerName("shaft")); });
  await settled();
  for (let pause = 0; pause < 2; pause++) {
    await vi.advanceTimersByTimeAsync(PAUSE_MS);
    await settled();
  }
  expect(shown.at(-1)).toBe("shaft of steel");
  expect(asked).toHaveBeenCalledTimes(3);
  leave();
});

test("a name that is wanted while it is asked is asked for afterwards", async () => {
  let answer: (found: ReturnType<typeof removed>) => void = () => undefined;
  asked.mockImplementationOnce(() => new Promise((resolve) => { answer = resolve; })).mockResolvedValue(removed("disc", "ring"));
  formerName("disc");
  await settled();
  formerName("ring");
  await settled();
  expect(asked).toHaveBeenCalledTimes(1);
  answer(removed("disc"));
  await settled();
  await settled();
  expect(formerName("ring")).toBe("ring of steel");
});
