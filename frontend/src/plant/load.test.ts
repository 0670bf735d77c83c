import { signal } from "@preact/signals";
import { expect, test, vi } from "vitest";
import type { PlantFile } from "../api/types";
import { followChanges, followJoining } from "./load";

const plantOf = (...ids: string[]): PlantFile => ({ machines: ids.map((id) => ({ id })) }) as PlantFile;
const worldOf = (...ids: string[]) => ({ machines: new Map(ids.map((id) => [id, {}])) });

test("the plant is asked for anew when a machine comes that it does not have, and once", () => {
  const plant = signal<PlantFile | null>(null);
  const world = signal<ReturnType<typeof worldOf> | null>(worldOf("M1", "M2"));
  const ask = vi.fn();
  const end = followJoining(plant, world, ask);
  plant.value = plantOf("M1", "M2");
  expect(ask).not.toHaveBeenCalled();
  world.value = worldOf("M1", "M2", "M3");
  world.value = worldOf("M1", "M2", "M3");
  expect(ask).toHaveBeenCalledTimes(1);
  plant.value = plantOf("M1", "M2", "M3");
  world.value = worldOf("M1", "M3", "M4");
  expect(ask).toHaveBeenCalledTimes(2);
  end();
});

test("the plant is asked for anew when the gateway tells that it has changed, and once", () => {
  const world = signal<{ factory: { plant_at_s?: number | null } } | null>(null);
  const ask = vi.fn();
  const end = followChanges(world, ask);
  // The first that is told of is the one that was asked for.
  world.value = { factory: { plant_at_s: 5 } };
  world.value = { factory: { plant_at_s: 5 } };
  expect(ask).not.toHaveBeenCalled();
  world.value = { factory: { plant_at_s: 7 } };
  // While the stream is cut off nothing is told of it.
  world.value = null;
  world.value = { factory: { plant_at_s: 7 } };
  expect(ask).toHaveBeenCalledTimes(1);
  world.value = { factory: {} };
  world.value = { factory: { plant_at_s: 3 } };
  expect(ask).toHaveBeenCalledTimes(2);
  end();
});
