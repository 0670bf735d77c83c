import { effect } from "@preact/signals";
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { fetchDefinitions } from "../api/products";
import { formerOf, PAUSE_MS } from "./former";

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

/** A plant as it is once more after a change. */
const plantOf = (...ids: string[]) => ({ products: ids.map((id) => ({ id })) });

test("many names are asked for once, and those that nobody knows not again for the same plant", async () => {
  asked.mockResolvedValue(removed("plate"));
  const name = formerOf(plantOf());
  for (const id of ["plate", "nothing", "plate"]) expect(name(id)).toBe(id);
  await settled();
  expect([name("plate"), name("nothing"), name("something")]).toEqual(["plate of steel", "nothing", "something"]);
  await settled();
  expect(asked).toHaveBeenCalledTimes(1);
});

test("after a change of the plant a name that nobody knew is asked for again, and one that is known is not", async () => {
  asked.mockResolvedValueOnce(removed("plate")).mockResolvedValue(removed("plate", "late"));
  formerOf(plantOf())("late");
  await settled();
  const name = formerOf(plantOf());
  expect(name("plate")).toBe("plate of steel");
  await settled();
  expect(asked).toHaveBeenCalledTimes(1);
  expect(name("late")).toBe("late");
  await settled();
  expect(name("late")).toBe("late of steel");
  expect(asked).toHaveBeenCalledTimes(2);
});

test("what was defined anew and removed once more may have another name", async () => {
  asked.mockResolvedValueOnce(removed("bowl")).mockResolvedValue([{ ...removed("bowl")[0], name: "bowl of brass" }] as ReturnType<typeof removed>);
  formerOf(plantOf())("bowl");
  await settled();
  formerOf(plantOf("bowl"));
  const name = formerOf(plantOf());
  expect(name("bowl")).toBe("bowl");
  await settled();
  expect(name("bowl")).toBe("bowl of brass");
});

test("after an answer that failed it is asked again when a name is wanted, but not before a pause is over", async () => {
  asked.mockRejectedValueOnce(offline).mockResolvedValue(removed("bracket"));
  const name = formerOf(plantOf());
  name("bracket");
  await settled();
  for (const id of ["bracket", "flange", "bracket"]) {
    expect(name(id)).toBe(id);
    await settled();
  }
  await vi.advanceTimersByTimeAsync(PAUSE_MS);
  await settled();
  expect(asked).toHaveBeenCalledTimes(1);
  name("bracket");
  await settled();
  expect(name("bracket")).toBe("bracket of steel");
  expect(asked).toHaveBeenCalledTimes(2);
});

test("what shows an id meanwhile wants its name again by itself", async () => {
  asked.mockRejectedValueOnce(offline).mockRejectedValueOnce(offline).mockResolvedValue(removed("shaft"));
  const name = formerOf(plantOf());
  const shown: string[] = [];
  const leave = effect(() => { shown.push(name("shaft")); });
  await settled();
  for (let pause = 0; pause < 2; pause++) {
    await vi.advanceTimersByTimeAsync(PAUSE_MS);
    await settled();
  }
  expect(shown.at(-1)).toBe("shaft of steel");
  expect(asked).toHaveBeenCalledTimes(3);
  leave();
});

test("a name that is wanted of another plant while it is asked is asked for afterwards", async () => {
  let answer: (found: ReturnType<typeof removed>) => void = () => undefined;
  asked.mockImplementationOnce(() => new Promise((resolve) => { answer = resolve; })).mockResolvedValue(removed("disc", "ring"));
  const plant = plantOf();
  formerOf(plant)("disc");
  await settled();
  formerOf(plant)("cap");
  formerOf(plantOf())("ring");
  await settled();
  expect(asked).toHaveBeenCalledTimes(1);
  answer(removed("disc"));
  await settled();
  await settled();
  expect(asked).toHaveBeenCalledTimes(2);
  expect(formerOf(plantOf())("ring")).toBe("ring of steel");
});

test("nothing is asked for before there is a plant", async () => {
  expect(formerOf(null)("plate?")).toBe("plate?");
  await settled();
  expect(asked).not.toHaveBeenCalled();
});
