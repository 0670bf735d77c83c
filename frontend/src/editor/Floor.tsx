/** What is drawn of a plant: the running one in grey, what is new in the draft in blue. */
import { NUMBER, marksOf, nameBelow } from "./marks";
import * as model from "./model";
import { RepairMarks } from "./Repair";
import * as state from "./state";

interface Measures {
  readonly width_m: number;
  readonly height_m: number;
  /** About a pixel. */
  readonly unit_m: number;
}

export function Floor({ width_m, height_m, unit_m }: Measures) {
  const data = state.ghost.value ?? state.data.value;
  const mode = state.shown.value;
  const y = (y_m: number): number => height_m - y_m;
  const grid = state.grid_m.value * (width_m > 100 ? 10 : 2);
  const { x_m, y_m } = state.cursor.value;
  const begun = state.begun.value;
  return (
    <g class="ed-floor">
      <defs>
        <pattern id="ed-grid" width={grid} height={grid} patternUnits="userSpaceOnUse">
          <circle cx={0} cy={0} r={unit_m * 1.5} />
        </pattern>
      </defs>
      <rect class="ed-ground" width={width_m} height={height_m} />
      <PlanPicture y={y} />
      <rect class="ed-grid" width={width_m} height={height_m} fill="url(#ed-grid)" />
      {mode !== "alone" && <Plant data={state.running.value} y={y} unit_m={unit_m} class="ed-running" />}
      {mode !== "running" && <Plant data={data} y={y} unit_m={unit_m} class="ed-draft" mine />}
      {mode !== "running" && <RepairMarks y={y} unit_m={unit_m} />}
      {begun.length > 0 && (
        <polyline class="ed-begun" stroke-width={unit_m * 2} points={[...begun, state.cursor.value].map((spot) => `${spot.x_m},${y(spot.y_m)}`).join(" ")} />
      )}
      <path class="ed-cursor" stroke-width={unit_m * 1.5} d={`M${x_m - 0.4} ${y(y_m)}h.8M${x_m} ${y(y_m) - 0.4}v.8`} />
    </g>
  );
}

function PlanPicture({ y }: { y: (y_m: number) => number }) {
  const draft = state.draft.value;
  const plan = state.data.value.plan as model.Plan | undefined;
  if (!draft?.plan_type || !plan) return null;
  // Its height follows from the picture, so that its own rule of where it lies in a box, which browsers obey, has nothing to decide.
  return (
    <image
      class="ed-plan"
      href={`/api/plant-drafts/${draft.id}/plan#${state.picture.value}`}
      x={plan.x_m}
      y={y(plan.y_m)}
      width={plan.width_m}
      opacity={plan.opacity}
    />
  );
}

interface PlantProps {
  readonly data: model.Data;
  readonly y: (y_m: number) => number;
  readonly unit_m: number;
  readonly class: string;
  readonly mine?: boolean;
}

function Plant({ data, y, unit_m, class: kind, mine = false }: PlantProps) {
  const nodes = model.nodeById(data);
  const chosen = mine ? state.chosen.value : null;
  const numbers = mine ? marksOf(state.findings.value, data) : [];
  const found = new Set(numbers.map(({ key }) => key));
  const old = mine && state.shown.value === "over" ? known(state.running.value) : null;
  const is = (section: string, index: number, entry: object): string =>
    [
      chosen?.section === section && chosen.index === index ? "chosen" : "",
      found.has(`${section}[${index}]`) ? "faulty" : "",
      old && !old.has(JSON.stringify(entry)) ? "new" : "",
    ].join(" ");
  const places = model.places(data);
  const size = Math.min(Math.max(unit_m * 11, 0.5), 2);
  return (
    <g class={kind}>
      {model.entries<model.Area>(data, "areas").map((area, index) => (
        <polygon key={`a${index}`} class={`ed-area ${is("areas", index, area)}`} stroke-width={unit_m} data-section="areas" data-index={index} points={area.polygon.map((spot) => `${spot.x_m},${y(spot.y_m)}`).join(" ")} />
      ))}
      {model.lanesOf(data).map((lane, index) => {
        const [a, b] = [nodes.get(lane.start), nodes.get(lane.end)];
        if (!a || !b) return null;
        const points = [a, ...(lane.shape ?? []), b].map((spot) => `${spot.x_m},${y(spot.y_m)}`).join(" ");
        const closed = mine && model.isClosed(data, lane) ? "closed" : "";
        const door = model.doorAt(data, lane);
        const turn = (Math.atan2(y(b.y_m) - y(a.y_m), b.x_m - a.x_m) * 180) / Math.PI;
        const middle = `translate(${(a.x_m + b.x_m) / 2} ${(y(a.y_m) + y(b.y_m)) / 2}) rotate(${turn})`;
        return (
          <g key={`l${index}`} class={`ed-lane ${is("lanes", index, lane)} ${closed}`} data-section="lanes" data-index={index}>
            <polyline stroke-width={lane.both_ways ? 1.1 : 0.7} points={points} />
            {!lane.both_ways && !closed && <path transform={middle} d="M-.3 -.3 .3 0 -.3 .3Z" />}
            {door >= 0 && (
              <g class={`ed-door ${is("doors", door, model.entries<object>(data, "doors")[door] ?? {})}`} data-section="doors" data-index={door} transform={middle}>
                <path class="ed-reach" stroke-width={unit_m * 12} d="M0 -.9V.9" />
                <path stroke-width={unit_m * 3} d="M0 -.9V.9" />
              </g>
            )}
            {closed && <path class="ed-cross" stroke-width={unit_m * 2} transform={middle} d="M-.4 -.4 .4 .4M-.4 .4 .4 -.4" />}
          </g>
        );
      })}
      {places.map(({ section, index, place }) => {
        const node = nodes.get(place.node ?? "");
        const box = place.box ?? (node && { x_m: node.x_m, y_m: node.y_m, width_m: 1, depth_m: 1 });
        if (!box) return null;
        return (
          <g key={`${section}${index}`} class={`ed-place ed-${section} ${is(section, index, place)}`} data-section={section} data-index={index}>
            {node && <path class="ed-dock" stroke-width={unit_m} d={`M${node.x_m} ${y(node.y_m)}L${box.x_m} ${y(box.y_m)}`} />}
            <rect x={box.x_m - box.width_m / 2} y={y(box.y_m) - box.depth_m / 2} width={box.width_m} height={box.depth_m} rx={0.2} stroke-width={unit_m * 1.5} />
            {(mine || state.shown.value === "running") && <text x={box.x_m} y={y(box.y_m) + nameBelow(place.id, place.box, size)} font-size={size}>{place.id}</text>}
          </g>
        );
      })}
      {mine && model.entries<model.Node | null>(data, "nodes").map((node, index) =>
        node !== null &&
        nodes.get(node.id) === node && (
          <circle key={node.id} class={`ed-node ${is("nodes", index, node)}`} data-section="nodes" data-index={index} cx={node.x_m} cy={y(node.y_m)} r={Math.max(unit_m * 4, 0.18)} stroke-width={unit_m * 1.5} />
        ))}
      {numbers.map(({ key, number, spot }) => (
        <g key={key} class="ed-mark" transform={`translate(${spot.x_m} ${y(spot.y_m)}) scale(${unit_m})`}>
          <circle r={NUMBER.r} cx={NUMBER.x} cy={NUMBER.y} />
          <text x={NUMBER.x} y={NUMBER.y + 4} font-size={11}>{number}</text>
        </g>
      ))}
    </g>
  );
}

let lastRunning: model.Data | null = null;
let lastKnown = new Set<string>();

/** Everything that the running plant has, as it is written. */
function known(running: model.Data): Set<string> {
  if (lastRunning !== running) {
    lastRunning = running;
    lastKnown = new Set(model.SECTIONS.flatMap((section) => model.entries<object>(running, section).map((each) => JSON.stringify(each))));
  }
  return lastKnown;
}
