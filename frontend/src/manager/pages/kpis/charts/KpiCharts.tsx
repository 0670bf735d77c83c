import { computed, signal } from "@preact/signals";
import { fetchKpiHistory } from "../../../../api/client";
import type { KpiHistory } from "../../../../api/types";
import { nowS } from "../../../../stream/stream";
import { speakAlso } from "../../../../text/speech";
import { t, tables } from "../../../../text/views/records";
import { useRefreshed } from "../../../refreshed";
import { CHARTS } from "../charts";
import { type Range, RANGES } from "../history";
import { ChartCard } from "./ChartCard";
import { QualityCard } from "./QualityCard";
import "uplot/dist/uPlot.min.css";
import "./kpis.css";

/** A new minute is there once a minute. */
const AGAIN_MS = 30_000;

const range = signal<Range>("hour");

const spanS = computed(() => RANGES[range.value].spanS);

/** The view, once it has its words. */
export async function load(): Promise<typeof KpiCharts> {
  await speakAlso(tables);
  return KpiCharts;
}

/** Charts of the factory's figures, with the same figures in tables behind them. */
export function KpiCharts() {
  const { answer: history, failed } = useRefreshed(askHistory, AGAIN_MS);
  const { stepS } = RANGES[range.value];
  const found = history.value;
  const since = new Date((nowS.peek() - spanS.value) * 1000).toISOString();
  return (
    <main class="kpi-view" id="content" tabIndex={-1} aria-busy={!found && failed.value === null}>
      <header class="kpi-head">
        <h1>{t("kpis.title")}</h1>
        <p class="muted">{t("kpis.hint")}</p>
        <div class="table-aside">
          {failed.value !== null && (
            <span class="tone-warn" role="status">
              {t("kpis.failed", { reason: failed.value })}
            </span>
          )}
          <span class="segments" role="group" aria-label={t("kpis.range")}>
            {(Object.keys(RANGES) as Range[]).map((each) => (
              <button
                key={each}
                type="button"
                aria-pressed={range.value === each}
                onClick={() => {
                  range.value = each;
                }}
              >
                {t(`kpis.range.${each}`)}
              </button>
            ))}
          </span>
          <a class="button" href="#shift">
            {t("kpis.shift")}
          </a>
          <a
            class="button"
            href={`/api/kpis/history?since=${since}&step=${stepS}&format=csv`}
            download
            title={t("kpis.csvTitle")}
          >
            {t("promises.csv")}
          </a>
        </div>
      </header>
      {found && found.items.length > 0 ? (
        <div class="kpi-grid">
          {CHARTS.map((chart) => (
            <ChartCard key={chart.name} chart={chart} history={found} />
          ))}
          <QualityCard spanS={spanS} />
        </div>
      ) : (
        <p class="empty" role="status">
          {t(found ? "kpis.none" : "kpis.loading")}
        </p>
      )}
    </main>
  );
}

function askHistory(): Promise<KpiHistory> {
  const { stepS } = RANGES[range.value];
  return fetchKpiHistory(nowS.peek() - spanS.value, `${stepS}`);
}
