/** What solves a finding: a button that says the change, and its measure on the floor. */
import { format, t } from "../text/editor";
import { LABEL, labelPlaces, marksOf } from "./marks";
import * as model from "./model";
import * as state from "./state";

type Offered = NonNullable<state.Finding["repair"]>;

const words = ({ kind, name, distance_m, entry, also }: Offered): string => {
  const values = entry as { start?: string; node?: string } | null;
  const to = values?.start ?? values?.node ?? "";
  const m = format.number(distance_m, 1);
  if (kind === "shift") return t(also.length > 0 ? "repair.shiftRoad" : "repair.shift", { name, m });
  if (kind === "move") return t("repair.move", { name, m });
  if (kind === "back") return t("repair.back", { name, m });
  if (kind === "drop") return t("repair.drop", { m });
  if (kind === "stand") return t("repair.stand", { to });
  return t("repair.join", { to, m });
};

export function Repair({ of }: { of: state.Finding["repair"] | undefined }) {
  if (!of) return null;
  // What was drawn since the checks were made may be something else.
  const old = state.kept.value !== "kept";
  return (
    <button type="button" class="button small ed-repair" disabled={old} onClick={() => { state.chosen.value = null; state.draw(model.repaired(state.data.value, of)); }}>
      {words(of)}
    </button>
  );
}

/** The measures of all that is offered, each at its place. */
export function RepairMarks({ y, unit_m }: { y: (y_m: number) => number; unit_m: number }) {
  if (state.kept.value !== "kept") return null;
  const data = state.data.value;
  const px = ({ x_m, y_m }: model.Spot) => ({ x: x_m / unit_m, y: y(y_m) / unit_m });
  const measures = state.findings.value.flatMap(({ repair }) => {
    const [from, to] = repair?.measure ?? [];
    return repair && from && to ? [{ repair, from, to, middle: { x_m: (from.x_m + to.x_m) / 2, y_m: (from.y_m + to.y_m) / 2 } }] : [];
  });
  const places = labelPlaces(measures.map(({ middle }) => px(middle)), marksOf(state.findings.value, data).map(({ spot }) => px(spot)));
  return (
    <g class="ed-measures">
      {measures.map(({ repair, from, to, middle }, index) => {
        const { x, y: down } = places[index] ?? { x: 0, y: 0 };
        return (
          <g key={index}>
            <path stroke-width={unit_m * 2} d={`M${from.x_m} ${y(from.y_m)}L${to.x_m} ${y(to.y_m)}`} />
            <circle cx={to.x_m} cy={y(to.y_m)} r={unit_m * 4} />
            <g transform={`translate(${middle.x_m} ${y(middle.y_m)}) scale(${unit_m})`}>
              <rect x={x - LABEL.width / 2} y={down - LABEL.height / 2} width={LABEL.width} height={LABEL.height} rx={9} />
              <text x={x} y={down + 4} font-size={11}>{`${format.number(repair.distance_m, 1)} m`}</text>
            </g>
          </g>
        );
      })}
    </g>
  );
}
