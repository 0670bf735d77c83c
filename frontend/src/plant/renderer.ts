/**
 * Three canvases over one another: the floor (drawn anew on zoom, size and theme), the machines (when
 * one of them changes) and everything that moves (while something moves). Knows nothing of the page:
 * it is told what to show, and asks for the next picture only while one is needed.
 */
import type { Box, MachineView, PlantFile, TaskView } from "../api/types";
import { FleetMotion, type ShownVehicle } from "../motion/fleet-motion";
import { type Place, type Roads, roadsOf } from "../motion/roads";
import type { Frame, World } from "../stream/world";
import { format, t } from "../text";
import { type Detail, detailOf } from "./detail";
import type { Brush } from "./draw/brush";
import { drawFloor } from "./draw/floor";
import { drawAges, drawChosenWay, drawLinks, drawWays } from "./draw/lines";
import { drawMachine } from "./draw/machines";
import { drawMark } from "./draw/marks";
import { drawDots, drawVehicle, drawVehicleLabels, type Look, lookOf } from "./draw/vehicles";
import { boxOnScreen, fitView, type Region, type Size, toScreenX, toScreenY, type View, type Zoom, zoomed } from "./geometry";
import type { Layers } from "./layers";
import { type Guard, meshLinks, watchLinks } from "./links";
import { Marks } from "./marks";
import type { Palette } from "./palette";
import { isLost, isOverdue } from "./silence";

export interface Canvases {
  readonly floor: HTMLCanvasElement;
  readonly machines: HTMLCanvasElement;
  readonly moving: HTMLCanvasElement;
}

/** A plant, and the part of it that is shown at first. */
export interface Scene {
  readonly plant: PlantFile;
  readonly home: Region;
}

/** Room for the scale below the floor. */
const PAD = { left: 12, right: 12, top: 10, bottom: 32 };

/** What the map is told from outside. */
export interface Shown {
  readonly layers: Layers;
  readonly palette: Palette;
  readonly atv: string | null;
  readonly place: string | null;
}

export class PlantRenderer {
  readonly plant: PlantFile;
  readonly fleet: FleetMotion;
  /** Called after the scale has changed. */
  onZoom: () => void = () => undefined;
  readonly #home: Region;
  readonly #canvases: Canvases;
  readonly #roads: Roads;
  readonly #serverNowS: () => number;
  readonly #productNames: ReadonlyMap<string, string>;
  readonly #machineAt: ReadonlyMap<string, Place>;
  /** What has a name of its own, which no vehicle's name may cover. */
  readonly #walls: readonly Box[];
  readonly #marks = new Marks();
  #shown: Shown;
  #world: World | null = null;
  #size: Size = { width: 1, height: 1 };
  #zoom: Zoom = { k: 1, x: 0, y: 0 };
  #smooth = true;
  #frame: number | null = null;
  #drawnAtMs = 0;
  #stale = { floor: true, machines: true };

  constructor({ home, plant }: Scene, canvases: Canvases, shown: Shown, serverNowS: () => number) {
    this.plant = plant;
    this.#home = home;
    this.#canvases = canvases;
    this.#shown = shown;
    this.#serverNowS = serverNowS;
    this.#roads = roadsOf(plant);
    this.#productNames = new Map(plant.products.map((product) => [product.id, product.name]));
    this.#machineAt = new Map(plant.machines.map(({ box, id }) => [id, { x: box.x_m, y: box.y_m }]));
    this.#walls = [...plant.machines, ...plant.storages, ...plant.warehouses].map(({ box }) => box);
    this.fleet = new FleetMotion(this.#roads);
  }

  /** What is shown at first, in this much room; the zoom is relative to it. */
  get fit(): View {
    return fitView(this.#home, this.#size, PAD);
  }

  get view(): View {
    return zoomed(this.fit, this.#zoom);
  }

  get size(): Size {
    return this.#size;
  }

  /** Begins with everything as it stands: at first, and after a snapshot. */
  begin(world: World): void {
    this.fleet.reset(world.atvs.values());
    this.#know(world);
  }

  take(frame: Frame, world: World): void {
    if (frame.type === "snapshot") {
      this.begin(world);
      return;
    }
    this.fleet.observe(frame.atvs);
    this.#marks.observe(frame.news, performance.now());
    for (const id of frame.gone) if (id.startsWith("atv:")) this.fleet.forget(id.slice(4));
    this.#know(world);
  }

  #know(world: World): void {
    if (world.machines !== this.#world?.machines) this.#stale.machines = true;
    this.#world = world;
    this.#ask();
  }

  show(shown: Shown): void {
    const { palette, layers, place } = this.#shown;
    if (shown.palette !== palette || shown.layers !== layers || shown.place !== place) {
      this.#stale = { floor: true, machines: true };
    }
    this.#shown = shown;
    this.#ask();
  }

  resize(size: Size): void {
    this.#size = size;
    const ratio = Math.min(2, devicePixelRatio);
    for (const canvas of Object.values(this.#canvases) as HTMLCanvasElement[]) {
      canvas.width = Math.round(size.width * ratio);
      canvas.height = Math.round(size.height * ratio);
      canvas.getContext("2d")?.setTransform(ratio, 0, 0, ratio, 0, 0);
    }
    this.redraw();
  }

  zoomTo(zoom: Zoom): void {
    this.#zoom = zoom;
    this.redraw();
    this.onZoom();
  }

  /** @param smooth false for people who asked for less motion: positions change with the news only */
  setSmooth(smooth: boolean): void {
    this.#smooth = smooth;
    this.#ask();
  }

  /** Everything anew: size, zoom, or fonts that have arrived. */
  redraw(): void {
    this.#stale = { floor: true, machines: true };
    this.#ask();
  }

  stop(): void {
    if (this.#frame !== null) cancelAnimationFrame(this.#frame);
    this.#frame = null;
  }

  #ask(): void {
    this.#frame ??= requestAnimationFrame((ms) => {
      this.#frame = null;
      this.#draw(ms);
    });
  }

  #draw(ms: number): void {
    const speed = this.#world?.factory.speed ?? 1;
    const passedS = (ms - this.#drawnAtMs) / 1000;
    this.#drawnAtMs = ms;
    const nowS = this.#serverNowS();
    const moving = this.fleet.play({ serverS: nowS, passedS, speed, smooth: this.#smooth });
    const vehicles = this.#inSight();
    const detail = detailOf(this.view.scale, vehicles.length);
    if (this.#stale.floor) this.#drawFloor(detail);
    if (this.#stale.machines) this.#drawMachines(detail);
    this.#stale = { floor: false, machines: false };
    const marks = this.#marks.shown(ms, this.#smooth);
    this.#drawMoving(detail, vehicles, nowS, marks);
    if ((moving || marks.length > 0) && this.#smooth) this.#ask();
  }

  #brush(canvas: HTMLCanvasElement, detail: Detail): Brush | null {
    const ctx = canvas.getContext("2d");
    if (!ctx) return null;
    ctx.clearRect(0, 0, this.#size.width, this.#size.height);
    return { ctx, view: this.view, palette: this.#shown.palette, detail };
  }

  #drawFloor(detail: Detail): void {
    const brush = this.#brush(this.#canvases.floor, detail);
    if (!brush) return;
    const { areas, labels } = this.#shown.layers;
    drawFloor(brush, {
      plant: this.plant,
      roads: this.#roads,
      showAreas: areas,
      showLabels: labels,
      chosen: this.#shown.place,
    });
  }

  #drawMachines(detail: Detail): void {
    const brush = this.#brush(this.#canvases.machines, detail);
    if (!brush) return;
    for (const spec of this.plant.machines) {
      const view: MachineView | undefined = this.#world?.machines.get(spec.id);
      const lost = view !== undefined && isLost(view, this.#serverNowS(), this.#world?.factory.speed ?? 1);
      const product = this.#productNames.get(view?.product ?? "") ?? "";
      drawMachine(brush, { spec, view, product, lost, chosen: spec.id === this.#shown.place });
    }
  }

  #drawMoving(
    detail: Detail,
    vehicles: readonly ShownVehicle[],
    nowS: number,
    marks: ReturnType<Marks["shown"]>,
  ): void {
    const brush = this.#brush(this.#canvases.moving, detail);
    const world = this.#world;
    if (!brush || !world) return;
    const { layers, atv } = this.#shown;
    // Who is silent may have plans, but nobody knows whether it still follows them.
    const onItsWay = ({ view }: ShownVehicle): boolean =>
      view.way.length > 0 && !isLost(view, nowS, world.factory.speed);
    if (layers.ways && detail.everybody) {
      const others = vehicles.filter((vehicle) => vehicle.view.id !== atv && onItsWay(vehicle));
      drawWays(brush, others.map(({ view }) => this.fleet.ahead(view.id)));
    }
    if (layers.watch) this.#drawWatch(brush, world.tasks, vehicles, nowS);
    if (layers.mesh) drawLinks(brush, meshLinks(vehicles, this.#find), "mesh", true);
    const chosen = atv === null ? undefined : this.fleet.get(atv);
    if (layers.ways && chosen && onItsWay(chosen)) drawChosenWay(brush, this.fleet.ahead(chosen.view.id));
    for (const { from, look, to } of marks) drawMark(brush, this.#find(from), this.#find(to), look);
    this.#drawVehicles(brush, vehicles, nowS);
  }

  #drawWatch(
    brush: Brush,
    tasks: ReadonlyMap<string, TaskView>,
    inSight: readonly ShownVehicle[],
    nowS: number,
  ): void {
    const { atv, place } = this.#shown;
    const speed = this.#world?.factory.speed ?? 1;
    if (brush.detail.everybody) {
      // Lines that only pass through would say nothing.
      const seen = new Map(inSight.map((vehicle) => [vehicle.view.id, vehicle]));
      const all = watchLinks(tasks.values(), (id) => seen.get(id), null);
      drawLinks(brush, all.secondary, "secondary", false);
    }
    const chosen = watchLinks(tasks.values(), this.#find, { atv, machine: place });
    drawLinks(brush, chosen.primary, "primary", true);
    drawLinks(brush, chosen.secondary, "secondary", true);
    const aged = (guards: readonly Guard[]) =>
      guards.flatMap((guard) => {
        const view = this.fleet.get(guard.guarded)?.view;
        if (!view) return [];
        const age = format.age(nowS - view.seen_at_s);
        return [{ ...guard, age, overdue: isOverdue(view, nowS, speed) }];
      });
    // Whoever is not heard in time is looked for, whatever is chosen.
    const overdue = aged(watchLinks(tasks.values(), this.#find, null).secondary).filter((each) => each.overdue);
    drawLinks(brush, overdue, "overdue", true);
    drawAges(brush, [...aged(chosen.secondary).filter((each) => !each.overdue), ...overdue]);
  }

  #drawVehicles(brush: Brush, vehicles: readonly ShownVehicle[], nowS: number): void {
    const speed = this.#world?.factory.speed ?? 1;
    const looks = vehicles.map((vehicle) => {
      const chosen = vehicle.view.id === this.#shown.atv;
      const look = lookOf(vehicle.view, chosen, isLost(vehicle.view, nowS, speed));
      const { id, seen_at_s: seenAtS } = vehicle.view;
      const label = look === "lost" ? t("map.silent", { id, age: format.age(nowS - seenAtS) }) : id;
      return { vehicle, look, chosen, label };
    });
    // Whoever matters is drawn last, and so on top; and named first.
    looks.sort((a, b) => URGENCY[b.look] - URGENCY[a.look]);
    if (brush.detail.vehicleParts) {
      for (const { vehicle, look, chosen } of looks) drawVehicle(brush, vehicle, look, chosen);
    } else {
      for (const look of ["lost", "charging", "idle", "normal", "alarm"] as const) {
        drawDots(brush, looks.filter((each) => each.look === look).map(({ vehicle }) => vehicle), look);
      }
      const chosen = looks.find((each) => each.chosen);
      if (chosen) drawVehicle(brush, chosen.vehicle, chosen.look, true);
    }
    const named = brush.detail.vehicleLabels && this.#shown.layers.labels;
    const walls = this.#walls.map((box) => boxOnScreen(brush.view, box));
    drawVehicleLabels(brush, looks.toReversed().filter((each) => named || each.chosen), walls);
  }

  #inSight(): ShownVehicle[] {
    const { view, size } = this;
    const slack = 30;
    const seen: ShownVehicle[] = [];
    for (const vehicle of this.fleet.all()) {
      const x = toScreenX(view, vehicle.x);
      const y = toScreenY(view, vehicle.y);
      if (x > -slack && x < size.width + slack && y > -slack && y < size.height + slack) {
        seen.push(vehicle);
      }
    }
    return seen;
  }

  /** Where somebody is drawn: a vehicle as it moves, a machine in the middle of its box. */
  readonly #find = (id: string): Place | undefined => this.fleet.get(id) ?? this.#machineAt.get(id);
}

const URGENCY: Readonly<Record<Look, number>> = {
  chosen: 0,
  alarm: 1,
  lost: 2,
  normal: 3,
  idle: 4,
  charging: 5,
};
