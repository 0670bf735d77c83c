/** Where the vehicle is on the lanes, and how it gets somewhere else. */

import type { Body, Instruction, Report } from './body.ts';
import type { Plant, Point, VehicleType, Way } from './plant.ts';

const ORDERS_PER_LIFE = 1_000_000;

export class Driver {
  readonly type: VehicleType;
  /** The last node that was passed. */
  node: string;
  /** When the present way should end (plant clock). */
  arrives_s = 0;
  #plant: Plant;
  #body: Body;
  #order: number;
  #way: readonly string[] = [];
  #passed = 0;

  constructor(plant: Plant, type: VehicleType, body: Body, life: number, now_s: number) {
    this.#plant = plant;
    this.type = type;
    this.#body = body;
    this.#order = life * ORDERS_PER_LIFE;
    const { node, next_node, next_node_s } = body.state;
    this.node = node;
    // A way of an earlier life ends where its lane ends.
    if (next_node !== node) this.#take([next_node], now_s + next_node_s);
  }

  get isDriving(): boolean {
    return this.#way.length > 0;
  }

  get ahead(): readonly string[] {
    return this.#way.slice(this.#passed);
  }

  /** Where another way could begin. */
  get next(): string {
    return this.#way[this.#passed] ?? this.node;
  }

  get place(): Point {
    return this.isDriving ? this.#body.state.pose : this.#plant.point(this.node);
  }

  wayTo(node: string): Way | undefined {
    return this.#plant.way(this.next, node, this.type);
  }

  way(from: string, to: string): Way | undefined {
    return this.#plant.way(from, to, this.type);
  }

  /** Seconds until the vehicle is where another way could begin. */
  get next_s(): number {
    if (!this.isDriving) return 0;
    const [here, there] = [this.#body.state.pose, this.#plant.point(this.next)];
    return Math.hypot(there.x_m - here.x_m, there.y_m - here.y_m) / Math.max(this.#body.state.speed_mps, 0.3);
  }

  /** Set off; false when it stands there already. */
  go(node: string, now_s: number): boolean {
    if (!this.isDriving && this.node === node) return false;
    const way = this.wayTo(node);
    if (!way) throw new Error(`no way leads from ${this.next} to ${node}`);
    this.#take(way.nodes, now_s + this.next_s + way.duration_s);
    return true;
  }

  /** Stand at the end of this lane. */
  halt(now_s: number): void {
    if (this.isDriving) this.#take([this.next], now_s + this.next_s);
  }

  /** Let the standing vehicle do something; the number by which its report is known. */
  act(instruction: (order: number) => Instruction): number {
    this.#order += 1;
    this.#body.instruct(instruction(this.#order));
    return this.#order;
  }

  /** Take a report about ways; whether the vehicle has just come to the end of the present one, or has lost it. */
  onReport(report: Report): 'arrived' | 'refused' | undefined {
    if (report.kind === 'NodePassed') {
      this.node = report.node;
      if (report.order === this.#order && this.isDriving) this.#passed = report.index + 1;
    } else if (report.kind === 'WayDone') {
      this.node = report.node;
      if (report.order === this.#order) return this.#end('arrived');
    } else if (report.kind === 'ActionFailed' && report.order === this.#order && this.isDriving) {
      return this.#end('refused');
    }
    return undefined;
  }

  #take(nodes: readonly string[], arrives_s: number): void {
    this.#order += 1;
    this.#way = nodes;
    this.#passed = 0;
    this.arrives_s = arrives_s;
    // The whole way is released at once: no rule of right of way exists yet.
    this.#body.instruct({ kind: 'Drive', order: this.#order, nodes, released: nodes.length });
  }

  #end(how: 'arrived' | 'refused'): 'arrived' | 'refused' {
    this.#way = [];
    this.#passed = 0;
    return how;
  }
}
