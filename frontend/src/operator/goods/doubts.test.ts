import { expect, test } from "vitest";
import { doubtsOf } from "./doubts";

const doubt = (load: string, item: string) => ({ load, vehicle: "ATV5", item, name: item, quantity: 10, brought: false });
const level = (item: string, pieces: number) => ({ item, level: pieces, capacity: 80, reorder_point: 0, on_order: 0, spare: 0 });
const stock = (item: string, pieces: number) => ({ item, level: pieces, capacity: 80, promised: 0, wanted: 0, on_order: 0, uncounted: false });

test("doubtful loads are named with their place and with what the stock says", () => {
  const machine = { id: "M5", doubts: [doubt("M5-load-1", "pump-p3")], buffers: [level("shaft", 3)], goods: [level("pump-p3", 20)] };
  const station = { id: "S1", doubts: [doubt("S1-load-1", "shaft"), doubt("S1-load-2", "rotor")], stocks: [stock("shaft", 4)] };
  const found = doubtsOf({ machines: new Map([["M5", machine]]), stations: new Map([["S1", station]]) });
  expect(found.map(({ load, level: pieces, station: isStation }) => [load, pieces, isStation])).toEqual([
    ["M5-load-1", 20, false],
    ["S1-load-1", 4, true],
    ["S1-load-2", 0, true],
  ]);
});
