/** Machines: a box with its name, what it is doing, and how full its buffers are. */
import type { MachineSpec, MachineView } from "../../api/types";
import { boxOnScreen, type Rect } from "../surface/geometry";
import { filledFrac, isLow } from "../stock";
import { type Brush, setFont, textPx } from "./brush";
import { rectOfWords } from "./words";

export interface DrawnMachine {
  readonly spec: MachineSpec;
  /** Undefined for a machine that was never heard. */
  readonly view: MachineView | undefined;
  readonly chosen: boolean;
  /** Silent: what it said last is a memory. */
  readonly lost: boolean;
  readonly product: string;
}

/** Returns where its words stand. */
export function drawMachine(brush: Brush, machine: DrawnMachine): Rect[] {
  const rect = boxOnScreen(brush.view, machine.spec.box);
  drawBody(brush, rect, machine);
  const words = brush.detail.placeLabels ? drawNames(brush, rect, machine) : [];
  if (!machine.lost && brush.detail.machineParts && machine.view) {
    drawBuffers(brush, rect, machine.view);
    drawSign(brush, rect, machine.view.status);
  }
  return words;
}

function drawBody({ ctx, view, palette }: Brush, rect: Rect, machine: DrawnMachine): void {
  const { left, top, right, bottom } = rect;
  const status = machine.view?.status;
  const alarm = status === "error" || machine.lost;
  const abnormal = alarm ? "alarm" : status === "starved" || status === "blocked" ? "warn" : null;
  ctx.beginPath();
  ctx.roundRect(left, top, right - left, bottom - top, Math.min(8, 0.45 * view.scale));
  ctx.fillStyle = machine.lost ? palette.lane : abnormal ? palette[`${abnormal}-soft`] : palette.machine;
  ctx.fill();
  ctx.lineWidth = Math.min(3, Math.max(1, (abnormal ? 0.16 : 0.12) * view.scale));
  ctx.strokeStyle = abnormal ? palette[abnormal] : palette["machine-edge"];
  if (!machine.view || machine.lost) ctx.setLineDash([4, 3]);
  ctx.stroke();
  ctx.setLineDash([]);
  if (!machine.chosen) return;
  ctx.beginPath();
  ctx.roundRect(left - 3, top - 3, right - left + 6, bottom - top + 6, Math.min(10, 0.6 * view.scale));
  ctx.lineWidth = 2.5;
  ctx.strokeStyle = palette.chosen;
  ctx.stroke();
}

/** Wide enough for the product's name beside the machine's. */
const PRODUCT_FROM_PX = 110;

function drawNames(brush: Brush, rect: Rect, machine: DrawnMachine): Rect[] {
  const { ctx, view, palette, detail } = brush;
  const width = rect.right - rect.left;
  const height = rect.bottom - rect.top;
  const middle = (rect.left + rect.right) / 2;
  const px = textPx(view.scale, 1.15, 9, 22);
  const withProduct = width >= PRODUCT_FROM_PX && machine.product !== "" && !machine.lost;
  const y = rect.top + height * (detail.machineParts ? (withProduct ? 0.3 : 0.4) : 0.52);
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  const { status } = machine.view ?? {};
  // A warning or an alarm has a ground of its own.
  const warned = status === "starved" || status === "blocked";
  const ink = warned ? (machine.chosen ? "chosen" : "steel-ink") : machine.chosen ? "machine-chosen" : "machine-ink";
  ctx.fillStyle = palette[status === "error" || machine.lost ? "alarm" : ink];
  setFont(brush, px, 650);
  // A long name gives way to the sign in the corner.
  ctx.fillText(machine.spec.id, middle, y, width * 0.66);
  const name = rectOfWords(middle, y, px, Math.min(width * 0.66, ctx.measureText(machine.spec.id).width));
  if (!withProduct) return [name];
  const smallPx = Math.max(10, px * 0.6);
  const low = rect.top + height * 0.56;
  setFont(brush, smallPx, 450);
  ctx.fillStyle = palette[warned || status === "error" ? "ink-2" : "machine-part"];
  ctx.fillText(machine.product, middle, low, width - 10);
  return [name, rectOfWords(middle, low, smallPx, Math.min(width - 10, ctx.measureText(machine.product).width))];
}

/** Materials in a row, then a gap, then the finished goods. */
function drawBuffers({ ctx, view, palette }: Brush, rect: Rect, machine: MachineView): void {
  const buffers = [...machine.buffers, ...machine.goods];
  if (buffers.length === 0) return;
  const inset = 0.45 * view.scale;
  const gap = Math.max(2, 0.22 * view.scale);
  const width = rect.right - rect.left - 2 * inset;
  const each = Math.min(1.4 * view.scale, (width - gap * (buffers.length - 1)) / buffers.length);
  const tall = Math.min(12, Math.max(2.5, 0.36 * view.scale));
  const y = rect.bottom - inset - tall * 0.9;
  let x = (rect.left + rect.right) / 2 - (each * buffers.length + gap * (buffers.length - 1)) / 2;
  buffers.forEach((buffer, i) => {
    const goods = i >= machine.buffers.length;
    ctx.fillStyle = palette.lane;
    fillPill(ctx, x, y, each, tall);
    ctx.fillStyle = goods ? palette["steel-ink"] : isLow(buffer) ? palette.warn : palette.steel;
    fillPill(ctx, x, y, each * filledFrac(buffer), tall);
    x += each + gap;
  });
}

function fillPill(ctx: CanvasRenderingContext2D, x: number, y: number, w: number, h: number): void {
  if (w <= 0) return;
  ctx.beginPath();
  ctx.roundRect(x, y, w, h, Math.min(h, w) / 2);
  ctx.fill();
}

/** Says the status by shape, in the corner: colour alone would not do. */
function drawSign({ ctx, view, palette }: Brush, rect: Rect, status: MachineView["status"]): void {
  const r = Math.min(9, Math.max(3, 0.38 * view.scale));
  const x = rect.right - r * 1.9;
  const y = rect.top + r * 1.9;
  ctx.beginPath();
  switch (status) {
    case "idle":
      return;
    case "producing":
      ctx.moveTo(x - 0.5 * r, y - 0.7 * r);
      ctx.lineTo(x + 0.7 * r, y);
      ctx.lineTo(x - 0.5 * r, y + 0.7 * r);
      ctx.closePath();
      ctx.fillStyle = palette["machine-sign"];
      break;
    case "blocked":
      ctx.rect(x - 0.65 * r, y - 0.65 * r, 1.3 * r, 1.3 * r);
      ctx.fillStyle = palette.warn;
      break;
    case "starved":
      // An empty bowl: nothing to work with.
      ctx.arc(x, y - 0.4 * r, r * 0.9, 0, Math.PI);
      ctx.closePath();
      ctx.lineWidth = Math.max(1.5, 0.3 * r);
      ctx.strokeStyle = palette.warn;
      ctx.stroke();
      return;
    case "error":
      ctx.moveTo(x, y - r);
      ctx.lineTo(x + r, y + 0.8 * r);
      ctx.lineTo(x - r, y + 0.8 * r);
      ctx.closePath();
      ctx.fillStyle = palette.alarm;
      break;
  }
  ctx.fill();
}
