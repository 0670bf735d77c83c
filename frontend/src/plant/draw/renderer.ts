/**
 * Three canvases over one another: the floor (drawn anew on zoom, size and theme), the machines (when
 * one of them changes) and everything that moves (while something moves). Knows nothing of the page:
 * it is told what to show, and asks for the next picture only while one is needed.
 */
import { bring } from "../../api/bring";
import type { Box, PlantFile, TaskView } from "../../api/types";
import { FleetMotion, type ShownVehicle } from "../../motion/fleet-motion";
import { type Place, type Roads, roadsOf } from "../../motion/roads";
import { toldOf, type Frame, type World } from "../../stream/world";
import { format, t } from "../../text";
import { factoryTime } from "../../text/plant-time";
import { type Detail, detailOf } from "./detail";
import { type Brush, isInSight, isOnScreen } from "./brush";
import { type AreaName, areaNames, drawFloor, parkingSignPx } from "./floor";
import { agesOn, drawChosenWay, drawLinks, drawWays } from "./lines";
import { drawMachine } from "./machines";
import { drawMark } from "./marks";
import { obstacleSigns } from "./obstacles";
import { discOf, drawDots, drawVehicle, lookOf, namesOf, shortName } from "./vehicles";
import { type Words, writeWords } from "./words";
import { boxOnScreen, fitView, type Rect, type Region, type Size, toScreenX, toScreenY, type View, type Zoom, zoomed } from "../surface/geometry";
import { groupsOf, URGENT_LAST } from "./groups";
import type { Heat } from "../heat/heat";
import { hasTraffic, heldAhead, heldLine, jamsOf, waitLines } from "../held/held";
import { type Drawing, loadDrawing } from "../held/shown";
import type { Layers } from "../controls/layers";
import { laneOf } from "../surface/lanes";
import { type Guard, isCarried, meshLinks, watchLinks } from "../surface/links";
import { lookAlike, machineLooks, type MachineLooks } from "./machine-looks";
import { Marks } from "../surface/marks";
import type { Palette } from "./palette";
import type { Outline } from "../../selection/outline";
import { isLost, isOverdue } from "../silence";

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
  /** Who would take over from it. */
  readonly standby: string | null;
  readonly place: string | null;
  /** The chosen lane, as `laneId` names it. */
  readonly lane: string | null;
  readonly heat: Heat | null;
  /** What somebody draws on the floor; null for nothing. */
  readonly outline: Outline | null;
}

export class PlantRenderer {
  readonly plant: PlantFile;
  readonly fleet: FleetMotion;
  /** Called after the scale has changed. */
  onZoom: () => void = () => undefined;
  readonly #home: Region;
  readonly #canvases: Canvases;
  readonly #roads: Roads;
  readonly #presentS: () => number;
  readonly #productNames: ReadonlyMap<string, string>;
  readonly #machineAt: ReadonlyMap<string, Place>;
  /** What has a name of its own, which no vehicle's name may cover. */
  readonly #walls: readonly Box[];
  readonly #marks = new Marks();
  #shown: Shown;
  #world: World | null = null;
  /** Transports that somebody carries. */
  #carried: readonly TaskView[] = [];
  #machines: MachineLooks = new Map();
  /** How right of way is drawn: null where there is none, or as long as it is being loaded. */
  #traffic: Drawing | null = null;
  #isLoading = false;
  /** How doors are drawn: null where there are none, or as long as it is being loaded. */
  #doors: typeof import("../doors/doors") | null = null;
  #size: Size = { width: 1, height: 1 };
  #zoom: Zoom = { k: 1, x: 0, y: 0 };
  #smooth = true;
  #frame: number | null = null;
  #drawnAtMs = 0;
  #stale = { floor: true, machines: true };
  /** As the floor was drawn last; null where areas are not shown. */
  #areas: readonly AreaName[] | null = null;
  /** Words in boxes and on closures, as they were written last. */
  readonly #written: { floor: readonly Rect[]; machines: readonly Rect[] } = { floor: [], machines: [] };

  constructor({ home, plant }: Scene, canvases: Canvases, shown: Shown, presentS: () => number) {
    this.plant = plant;
    this.#home = home;
    this.#canvases = canvases;
    this.#shown = shown;
    this.#presentS = presentS;
    this.#roads = roadsOf(plant);
    if (plant.doors.length > 0) {
      bring(() => import("../doors/doors"), (doors) => {
        this.#doors = doors;
        this.#ask();
      });
    }
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
    this.fleet.observe(toldOf(frame.atvs, world.atvs));
    this.#marks.observe(toldOf(frame.news, world.news), performance.now());
    for (const id of frame.gone) if (id.startsWith("atv:")) this.fleet.forget(id.slice(4));
    this.#know(world);
  }

  #know(world: World): void {
    if (world.closures !== this.#world?.closures || world.obstacles !== this.#world.obstacles) this.#stale.floor = true;
    if (world.tasks !== this.#world?.tasks) this.#carried = [...world.tasks.values()].filter(isCarried);
    const nowS = this.#presentS();
    const machines = machineLooks(this.#machineAt.keys(), world.machines, (view) => isLost(view, nowS, world.factory.speed));
    if (!lookAlike(this.#machines, machines)) this.#stale.machines = true;
    this.#machines = machines;
    this.#world = world;
    this.#loadTraffic(world);
    this.#ask();
  }

  #loadTraffic({ atvs }: World): void {
    if (this.#isLoading || !hasTraffic(atvs.values())) return;
    this.#isLoading = true;
    bring(loadDrawing, (drawing) => {
      this.#traffic = drawing;
      this.#ask();
    });
  }

  show(shown: Shown): void {
    const { heat, lane, layers, outline, palette, place } = this.#shown;
    const same = shown.outline === outline && shown.palette === palette && shown.layers === layers && shown.place === place && shown.lane === lane && shown.heat === heat;
    if (!same) {
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
    const nowS = this.#presentS();
    const moving = this.fleet.play({ serverS: nowS, passedS, speed, smooth: this.#smooth });
    const vehicles = this.#inSight();
    const detail = detailOf(this.view.scale, vehicles.length, this.#shown.layers.all);
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
    return { ctx, size: this.#size, view: this.view, palette: this.#shown.palette, detail };
  }

  #drawFloor(detail: Detail): void {
    const brush = this.#brush(this.#canvases.floor, detail);
    if (!brush) return;
    const { areas, labels } = this.#shown.layers;
    const obstacles = obstacleSigns(brush, this.#roads, this.#world?.obstacles.values() ?? [], this.plant.doors);
    const parkings = this.#parkingSigns(brush);
    this.#areas = areas ? areaNames(brush, this.plant, [...obstacles, ...parkings]) : null;
    this.#written.floor = drawFloor(brush, {
      plant: this.plant,
      roads: this.#roads,
      areas: this.#areas,
      showLabels: labels,
      heat: this.#shown.heat,
      chosen: this.#shown.place,
      closures: this.#world?.closures.values() ?? [],
      obstacles,
      parkings,
      lane: this.#shown.lane === null ? null : laneOf(this.#shown.lane),
      outline: this.#shown.outline,
      nowS: this.#presentS(),
    });
  }

  #drawMachines(detail: Detail): void {
    const brush = this.#brush(this.#canvases.machines, detail);
    if (!brush) return;
    this.#written.machines = this.plant.machines.flatMap((spec) => {
      if (!isInSight(brush, spec.box)) return [];
      const { view, lost = false } = this.#machines.get(spec.id) ?? {};
      const product = this.#productNames.get(view?.product ?? "") ?? "";
      return drawMachine(brush, { spec, view, product, lost, chosen: spec.id === this.#shown.place });
    });
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
    const jams = layers.traffic ? jamsOf(world.alerts.values(), world.waits, this.#find) : [];
    this.#traffic?.drawJams(brush, jams);
    if (layers.traffic) this.#drawHeld(brush, vehicles);
    const walls = this.#walls.filter((box) => isInSight(brush, box)).map((box) => boxOnScreen(brush.view, box));
    const beneath = { things: walls, words: this.#wordsBeneath(brush) };
    const doors = this.#doors?.drawDoors(brush, this.#roads, this.plant.doors, world, layers.labels, beneath) ?? [];
    // Who is silent may have plans, but nobody knows whether it still follows them.
    const onItsWay = ({ view }: ShownVehicle): boolean =>
      view.way.length > 0 && !isLost(view, nowS, world.factory.speed);
    if (layers.ways && detail.everybody) {
      const others = vehicles.filter((vehicle) => vehicle.view.id !== atv && onItsWay(vehicle));
      drawWays(brush, others.map(({ view }) => this.fleet.ahead(view.id)));
    }
    if (layers.primary) this.#drawPrimary(brush, vehicles);
    const ages = layers.watch ? this.#drawWatch(brush, vehicles, nowS) : [];
    if (layers.mesh) drawLinks(brush, meshLinks(vehicles, this.#find), "mesh", true);
    const chosen = atv === null ? undefined : this.fleet.get(atv);
    if (layers.ways && chosen && onItsWay(chosen)) drawChosenWay(brush, this.fleet.ahead(chosen.view.id));
    for (const { from, look, to } of marks) drawMark(brush, this.#find(from), this.#find(to), look);
    const names = this.#drawVehicles(brush, vehicles, nowS);
    if (layers.traffic) this.#traffic?.drawWaits(brush, waitLines(world.waits.values(), this.#find, atv));
    const speed = world.factory.speed;
    const told = jams.map((jam) => ({ ...jam, text: t("map.jam", { age: factoryTime((nowS - jam.sinceAtS) * speed, speed) }) }));
    // Beside what stands still, so that no sign jumps about while vehicles pass.
    const signs = this.#traffic?.jamSigns(brush, told, { things: walls, words: [...doors, ...beneath.words] }) ?? [];
    const discs = brush.detail.everybody ? vehicles.map((vehicle) => discOf(brush, vehicle)) : [];
    writeWords(brush, [...names.chosen, ...ages, ...names.others], {
      things: [...walls, ...discs],
      vehicles: discs,
      words: [...doors, ...signs.map(({ rect }) => rect), ...beneath.words],
    });
    this.#traffic?.nameJams(brush, signs);
  }

  /** Where words and signs stand on the floor and in boxes. */
  #wordsBeneath(brush: Brush): Rect[] {
    const { floor, machines } = this.#written;
    const areas = (this.#areas ?? []).map(({ rect }) => rect);
    return [...floor, ...machines, ...areas, ...this.#parkingSigns(brush)].filter((rect) => isOnScreen(brush, rect));
  }

  #drawHeld(brush: Brush, inSight: readonly ShownVehicle[]): void {
    const find = (node: string): Place | undefined => this.#roads.places.get(node);
    const lines = inSight.map(({ view }) => heldLine(view, this.fleet.ahead(view.id, heldAhead(view)), find));
    this.#traffic?.drawHeld(brush, lines);
  }

  #drawPrimary(brush: Brush, inSight: readonly ShownVehicle[]): void {
    const { atv, place } = this.#shown;
    if (brush.detail.everybody) {
      const seen = new Map(inSight.map((vehicle) => [vehicle.view.id, vehicle]));
      const find = (id: string): Place | undefined => seen.get(id) ?? this.#machineAt.get(id);
      drawLinks(brush, watchLinks(this.#carried, find, null).primary, "primary", false);
    }
    drawLinks(brush, watchLinks(this.#carried, this.#find, { atv, machine: place }).primary, "primary", true);
  }

  /** Returns how long ago they were heard who are watched. */
  #drawWatch(brush: Brush, inSight: readonly ShownVehicle[], nowS: number): Words[] {
    const { atv, place } = this.#shown;
    if (brush.detail.everybody) {
      // Lines that only pass through would say nothing.
      const seen = new Map(inSight.map((vehicle) => [vehicle.view.id, vehicle]));
      drawLinks(brush, watchLinks(this.#carried, (id) => seen.get(id), null).secondary, "secondary", false);
    }
    const chosen = watchLinks(this.#carried, this.#find, { atv, machine: place });
    drawLinks(brush, chosen.secondary, "secondary", true);
    // Whoever is not heard in time is looked for, whatever is chosen.
    const late = this.#carried.filter((task) => this.#isOverdue(task.primary, nowS));
    const overdue = watchLinks(late, this.#find, null).secondary;
    drawLinks(brush, overdue, "overdue", true);
    const heard = chosen.secondary.filter(({ guarded }) => !this.#isOverdue(guarded, nowS));
    return agesOn(brush, [...this.#aged(heard, nowS, false), ...this.#aged(overdue, nowS, true)]);
  }

  #isOverdue(atv: string, nowS: number): boolean {
    const view = this.fleet.get(atv)?.view;
    return view !== undefined && isOverdue(view, nowS, this.#world?.factory.speed ?? 1);
  }

  #aged(guards: readonly Guard[], nowS: number, overdue: boolean) {
    return guards.flatMap((guard) => {
      const view = this.fleet.get(guard.guarded)?.view;
      return view ? [{ ...guard, overdue, age: format.age(nowS - view.seen_at_s) }] : [];
    });
  }

  /** Returns their names. */
  #drawVehicles(brush: Brush, vehicles: readonly ShownVehicle[], nowS: number): { chosen: Words[]; others: Words[] } {
    const { atv, layers, standby } = this.#shown;
    const speed = this.#world?.factory.speed ?? 1;
    const groups = groupsOf(vehicles, ({ view }) => lookOf(view, view.id === atv, isLost(view, nowS, speed)));
    for (const look of URGENT_LAST) {
      if (!brush.detail.vehicleParts && look !== "chosen") drawDots(brush, groups[look], look);
      else for (const vehicle of groups[look]) drawVehicle(brush, vehicle, look, vehicle.view.id === atv, vehicle.view.id === standby);
    }
    const named = brush.detail.vehicleLabels && layers.labels;
    const labels = URGENT_LAST.toReversed().flatMap((look) =>
      groups[look].flatMap((vehicle) => {
        const { id, seen_at_s: seenAtS, shut_out: out } = vehicle.view;
        const chosen = id === atv || id === standby;
        if (!named && !chosen) return [];
        const name = shortName(id);
        const silent = out ? t("map.shutOut", { id: name }) : t("map.silent", { id: name, age: format.age(nowS - seenAtS) });
        const label = look === "lost" ? silent : name;
        return [{ vehicle, look, chosen, label }];
      }),
    );
    const of = (isChosen: boolean): Words[] => namesOf(brush, labels.filter(({ chosen }) => chosen === isChosen));
    return { chosen: of(true), others: of(false) };
  }

  /** The letters at parking places, where there are any. */
  #parkingSigns({ detail, view }: Brush): Rect[] {
    if (!detail.machineParts) return [];
    const half = parkingSignPx(view.scale) / 2;
    return this.plant.parkings.flatMap(({ node }) => {
      const at = this.#roads.places.get(node);
      if (!at) return [];
      const [x, y] = [toScreenX(view, at.x), toScreenY(view, at.y)];
      return [{ left: x - half, right: x + half, top: y - half, bottom: y + half }];
    });
  }

  #inSight(): ShownVehicle[] {
    const { view, size } = this;
    const slack = 30;
    const seen: ShownVehicle[] = [];
    for (const vehicle of this.fleet.all()) {
      // Carried away: it is not on the floor.
      if (vehicle.view.removal) continue;
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
