/** How the doors of a plant stand, as far as vehicles tell: no door speaks for itself. Loaded where a plant has doors. */
import type { AtvView, ObstacleView } from "../../api/types";
import type { Place, Roads } from "../../motion/roads";
import { type Rect, toScreenX, toScreenY } from "../surface/geometry";
import { type Brush, setFont } from "../draw/brush";
import { placed, type Taken } from "../draw/labels";
import { type Door, joins } from "./on";

export type DoorLook = "open" | "opening" | "shut" | "failed";

export interface Told {
  readonly atvs: ReadonlyMap<string, AtvView>;
  readonly obstacles: ReadonlyMap<string, ObstacleView>;
  /** Vehicles that wait for somebody else. */
  readonly waits: ReadonlyMap<string, unknown>;
}

/** Nearer to its node than this a vehicle has not left it. */
const AT_NODE_M = 0.3;
/** Half of a door that is drawn across its lane. */
const HALF_M = 0.8;
/** Shorter than this nobody would see the wings of an open one. */
const LEAST_PX = 8;

/** Failed where vehicles have found it shut for good; else open as long as one is in it, and opening while one stands before it. */
export function lookOf({ lanes }: Door, { atvs, obstacles, waits }: Told, find: (node: string) => Place | undefined): DoorLook {
  const among = (start: string, end: string | undefined): boolean => lanes.some((lane) => joins(lane, start, end));
  if ([...obstacles.values()].some(({ end, start }) => among(start, end))) return "failed";
  let look: DoorLook = "shut";
  for (const atv of atvs.values()) {
    if (!among(atv.node, atv.way[0])) continue;
    const node = find(atv.node);
    const hasLeft = !node || Math.hypot(node.x - atv.x_m, node.y - atv.y_m) > AT_NODE_M;
    if (hasLeft || atv.speed_mps > 0) return "open";
    if ((atv.status === "working" || atv.status === "idle") && !waits.has(atv.id)) look = "opening";
  }
  return look;
}

/** How far its wings are apart, of the whole door. */
const APART = { open: 0.6, opening: 0.3, shut: 0, failed: 0 } as const;

/** Pixels per metre: on a smaller map a name would lie on that of a machine. */
const NAMED_SCALE = 18;
const NAME_PX = 11.5;
/** Of its letters, in the colour of the floor. */
const EDGE_PX = 3;
/** From the door to its name. */
const GAP_PX = 3;

/** Where the leaf of a door is drawn: its middle, and from there to its end. */
interface Leaf {
  readonly x: number;
  readonly y: number;
  readonly dx: number;
  readonly dy: number;
}

/**
 * Returns where signs and words stand beside them.
 *
 * @param named whether a door that has failed says its name
 * @param taken what else is there: its name stands beside it
 */
export function drawDoors(brush: Brush, roads: Roads, doors: readonly Door[], told: Told, named: boolean, taken: Taken): Rect[] {
  const { ctx, palette, view } = brush;
  const words: Rect[] = [];
  for (const door of doors) {
    const look = lookOf(door, told, (node) => roads.places.get(node));
    const leaves: Leaf[] = [];
    ctx.lineCap = "butt";
    ctx.strokeStyle = look === "failed" ? palette.alarm : look === "opening" ? palette.warn : palette.ink;
    ctx.lineWidth = Math.max(2.5, 0.22 * view.scale);
    for (const { end, start } of door.lanes) {
      const [a, b] = [roads.places.get(start), roads.places.get(end)];
      if (!a || !b) continue;
      const [ax, ay, bx, by] = [toScreenX(view, a.x), toScreenY(view, a.y), toScreenX(view, b.x), toScreenY(view, b.y)];
      const long = Math.hypot(bx - ax, by - ay) || 1;
      const half = Math.max(LEAST_PX, HALF_M * view.scale);
      const [x, y, dx, dy] = [(ax + bx) / 2, (ay + by) / 2, (half * (ay - by)) / long, (half * (bx - ax)) / long];
      leaves.push({ x, y, dx, dy });
      const apart = APART[look];
      ctx.beginPath();
      for (const side of [-1, 1]) {
        ctx.moveTo(x + side * dx, y + side * dy);
        ctx.lineTo(x + side * apart * dx, y + side * apart * dy);
      }
      ctx.stroke();
    }
    if (look === "failed") {
      const name = named && view.scale >= NAMED_SCALE ? door.name : "";
      words.push(...drawFailed(brush, leaves, name, { things: taken.things, words: [...taken.words, ...words] }));
    }
  }
  return words;
}

/**
 * One sign for all lanes of the door at one end of it, since vehicles stand before its middle, and its name at the other end, or
 * behind the sign; nowhere where other words stand at both.
 */
function drawFailed(brush: Brush, leaves: readonly Leaf[], name: string, { things, words }: Taken): Rect[] {
  const { ctx, palette, view } = brush;
  const [first] = leaves;
  if (!first) return [];
  const lies = Math.abs(first.dx) > Math.abs(first.dy);
  const x = leaves.reduce((sum, leaf) => sum + leaf.x, 0) / leaves.length;
  const y = leaves.reduce((sum, leaf) => sum + leaf.y, 0) / leaves.length;
  const far = Math.max(...leaves.map((leaf) => (lies ? Math.abs(leaf.x - x) + Math.abs(leaf.dx) : Math.abs(leaf.y - y) + Math.abs(leaf.dy))));
  const at = (away: number): [number, number] => (lies ? [x + away, y] : [x, y + away]);
  const r = Math.min(13, Math.max(8, 0.5 * view.scale));
  const [signX, signY] = at(-far - 0.5 * r);
  ctx.beginPath();
  ctx.arc(signX, signY, r, 0, 2 * Math.PI);
  ctx.fillStyle = palette.raised;
  ctx.fill();
  ctx.lineWidth = 2;
  ctx.moveTo(signX - 0.45 * r, signY - 0.45 * r);
  ctx.lineTo(signX + 0.45 * r, signY + 0.45 * r);
  ctx.moveTo(signX - 0.45 * r, signY + 0.45 * r);
  ctx.lineTo(signX + 0.45 * r, signY - 0.45 * r);
  ctx.stroke();
  const sign = { left: signX - r, right: signX + r, top: signY - r, bottom: signY + r };
  if (name === "") return [sign];
  setFont(brush, NAME_PX, 600);
  const size = { width: ctx.measureText(name).width + EDGE_PX, height: NAME_PX + 2 };
  const half = (lies ? size.width : size.height) / 2;
  const places = [far + GAP_PX + half, -far - 1.5 * r - GAP_PX - half].map((away) => {
    const [nameX, nameY] = at(away);
    return { x: nameX, y: nameY };
  });
  const [rect] = placed([{ ...size, must: true, places }], { things, words: [...words, sign] });
  if (!rect) return [sign];
  const [nameX, nameY] = [(rect.left + rect.right) / 2, (rect.top + rect.bottom) / 2];
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  ctx.lineWidth = EDGE_PX;
  ctx.lineJoin = "round";
  ctx.strokeStyle = palette.floor;
  ctx.fillStyle = palette.alarm;
  ctx.strokeText(name, nameX, nameY);
  ctx.fillText(name, nameX, nameY);
  return [sign, rect];
}
