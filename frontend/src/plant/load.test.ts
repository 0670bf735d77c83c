import { signal } from "@preact/signals";
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { fetchPlant } from "../api/client";
import type { PlantFile } from "../api/types";
import { followChanges, PAUSE_MS, plantLoading, SPREAD_MS } from "./load";

vi.mock("../api/client", () => ({ fetchPlant: vi.fn() }));

const asked = vi.mocked(fetchPlant);
const plantOf = (name: string): PlantFile =>
  ({ name, machines: [], storages: [], warehouses: [], chargers: [], parkings: [], stations: [], areas: [], doors: [], nodes: [] }) as unknown as PlantFile;

/** Requests that are under way, each with its answer. */
function held() {
  const answers: ((name: string, atS: number) => Promise<void>)[] = [];
  asked.mockImplementation(async () => {
    return await new Promise((resolve) => {
      answers.push(async (name, atS) => {
        resolve({ plant: plantOf(name), atS });
        await vi.advanceTimersByTimeAsync(0);
      });
    });
  });
  return answers;
}

function panel(chance = 0.5) {
  const plant = signal<PlantFile | null>(null);
  const world = signal<{ factory: { plant_at_s?: number | null } } | null>(null);
  const failed = signal<string | null>(null);
  const loading = plantLoading(plant, failed, signal(null), String, () => chance);
  const end = followChanges(world, plant, loading);
  return { plant, failed, loading, end, tell: (atS?: number) => { world.value = { factory: { plant_at_s: atS ?? null } }; }, away: () => { world.value = null; } };
}

beforeEach(() => { vi.useFakeTimers(); });
afterEach(() => {
  asked.mockReset();
  vi.useRealTimers();
});

test("one request is under way at a time, and what is asked for meanwhile is one more", async () => {
  const answers = held();
  const { loading, plant } = panel();
  const all = [loading.now(), loading.now(), loading.now()];
  expect(asked).toHaveBeenCalledTimes(1);
  await answers[0]?.("older", 1);
  expect(plant.value).toMatchObject({ name: "older" });
  expect(asked).toHaveBeenCalledTimes(2);
  await answers[1]?.("newer", 2);
  await Promise.all(all);
  expect(plant.value).toMatchObject({ name: "newer" });
  expect(asked).toHaveBeenCalledTimes(2);
});

test("a plant that is not there is asked for until it is, and why not is said meanwhile", async () => {
  asked.mockRejectedValueOnce(new Error("not yet")).mockResolvedValue({ plant: plantOf("here"), atS: 1 });
  const { failed, loading, plant } = panel();
  await loading.now();
  expect(failed.value).toContain("not yet");
  await vi.advanceTimersByTimeAsync(10_000);
  expect(asked).toHaveBeenCalledTimes(2);
  expect([plant.value?.name, failed.value]).toEqual(["here", null]);
});

test("the plant that is there is not asked for again, also when it is told of for the first time", async () => {
  asked.mockResolvedValue({ plant: plantOf("here"), atS: 5 });
  const { end, loading, tell } = panel();
  tell(5);
  await loading.now();
  tell(5);
  await vi.advanceTimersByTimeAsync(60_000);
  expect(asked).toHaveBeenCalledTimes(1);
  end();
});

test("a change between the plant and the first word of the stream is seen", async () => {
  asked.mockResolvedValueOnce({ plant: plantOf("old"), atS: 5 }).mockResolvedValue({ plant: plantOf("new"), atS: 7 });
  const { end, loading, plant, tell } = panel();
  await loading.now();
  tell(7);
  await vi.advanceTimersByTimeAsync(PAUSE_MS + SPREAD_MS);
  expect([plant.value?.name, asked.mock.calls.length]).toEqual(["new", 2]);
  end();
});

test("a plant of which nobody tells when it changed is asked for once", async () => {
  asked.mockResolvedValue({ plant: plantOf("here"), atS: null });
  const { away, end, loading, tell } = panel();
  await loading.now();
  tell(7);
  await vi.advanceTimersByTimeAsync(60_000);
  // While the stream is cut off nothing is told of it.
  away();
  tell(7);
  await vi.advanceTimersByTimeAsync(60_000);
  expect(asked).toHaveBeenCalledTimes(2);
  tell(3);
  await vi.advanceTimersByTimeAsync(60_000);
  expect(asked).toHaveBeenCalledTimes(3);
  end();
});

test.each([[0, PAUSE_MS], [0.5, PAUSE_MS + SPREAD_MS / 2], [1, PAUSE_MS + SPREAD_MS]])("panels ask at different moments, by chance %f after %f ms, and once for changes in a row", async (chance, afterMs) => {
  asked.mockResolvedValueOnce({ plant: plantOf("old"), atS: 5 }).mockResolvedValue({ plant: plantOf("new"), atS: 9 });
  const { end, loading, tell } = panel(chance);
  await loading.now();
  for (const atS of [6, 7, 8, 9]) tell(atS);
  await vi.advanceTimersByTimeAsync(afterMs - 1);
  expect(asked).toHaveBeenCalledTimes(1);
  await vi.advanceTimersByTimeAsync(1);
  expect(asked).toHaveBeenCalledTimes(2);
  await vi.advanceTimersByTimeAsync(60_000);
  expect(asked).toHaveBeenCalledTimes(2);
  end();
});

test("who has changed it asks at once, and not again when the stream tells of it", async () => {
  asked.mockResolvedValueOnce({ plant: plantOf("old"), atS: 5 }).mockResolvedValue({ plant: plantOf("new"), atS: 7 });
  const { end, loading, plant, tell } = panel();
  await loading.now();
  await loading.now();
  expect(plant.value).toMatchObject({ name: "new" });
  tell(7);
  await vi.advanceTimersByTimeAsync(60_000);
  expect(asked).toHaveBeenCalledTimes(2);
  end();
});
