import type { Signal } from "@preact/signals";
import { format, t, word } from "../../text";
import { factoryTime } from "../../text/plant-time";
import { type Heat, MEASURES } from "./heat";
import { measure, period, PERIODS } from "./traffic";

/** What the shades of the lanes mean, and the choice of what they show. */
export function HeatLegend({ heat }: { heat: Heat }) {
  const { steps } = heat;
  return (
    <div class="heat-legend">
      <Choice label={t("map.heat.measure")} among={MEASURES} of={measure} />
      <Choice label={t("map.heat.period")} among={Object.keys(PERIODS) as (keyof typeof PERIODS)[]} of={period} />
      {steps.length === 0 && <span>{t("map.heat.none")}</span>}
      <ul>
        {steps.map((from, step) => (
          <li key={step}>
            <i style={{ opacity: (step + 1) / steps.length }} aria-hidden="true" />
            <span class="num">
              {t("map.heat.from", { figure: heat.measure === "waited_s" ? factoryTime(from) : format.count(from) })}
            </span>
          </li>
        ))}
      </ul>
    </div>
  );
}

function Choice<T extends string>({ among, label, of }: { among: readonly T[]; label: string; of: Signal<T> }) {
  return (
    <select
      aria-label={label}
      value={of.value}
      onChange={(event) => {
        of.value = event.currentTarget.value as T;
      }}
    >
      {among.map((each) => (
        <option key={each} value={each}>
          {word("map.heat", each)}
        </option>
      ))}
    </select>
  );
}
