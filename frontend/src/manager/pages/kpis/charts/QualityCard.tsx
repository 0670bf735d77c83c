import type { ReadonlySignal } from "@preact/signals";
import { fetchQuality } from "../../../../api/client";
import type { QualityAnswer } from "../../../../api/types";
import { Card } from "../../../../parts/Card";
import { byId } from "../../../../plant/places";
import { Link } from "../../../../parts/Link";
import { nowS } from "../../../../stream/stream";
import { format, t } from "../../../../text/views/records";
import { useRefreshed } from "../../../refreshed";
import { names } from "../../../state";
import { shownValue } from "./shown";

/** Each piece is counted within seconds. */
const AGAIN_MS = 30_000;

/** Good and bad pieces, and the quality ratio, by machine and product. */
export function QualityCard({ spanS }: { spanS: ReadonlySignal<number> }) {
  const { answer, failed } = useRefreshed(() => fetchQuality(nowS.peek() - spanS.value), AGAIN_MS);
  const found = answer.value;
  const title = t("kpis.quality");
  return (
    <Card
      title={title}
      class="kpi-card kpi-quality"
      aside={
        <span class="table-aside">
          <a
            class="button"
            href={`/api/kpis/quality?since=${new Date((nowS.peek() - spanS.value) * 1000).toISOString()}&format=csv`}
            download
            title={t("kpis.qualityCsv")}
          >
            {t("promises.csv")}
          </a>
        </span>
      }
    >
      <p class="muted">{t("kpis.qualityHint")}</p>
      {failed.value !== null && (
        <p class="tone-warn" role="status">
          {t("kpis.failed", { reason: failed.value })}
        </p>
      )}
      {found &&
        (found.items.length > 0 ? (
          <Pieces found={found} title={title} />
        ) : (
          <p class="empty" role="status">
            {t("kpis.noPieces")}
          </p>
        ))}
    </Card>
  );
}

function Pieces({ found, title }: { found: QualityAnswer; title: string }) {
  const lines = [...found.items].sort((a, b) => byId({ id: a.machine }, { id: b.machine }));
  return (
    <div class="kpi-pieces" tabIndex={0} role="group" aria-label={title}>
      <table>
        <thead>
          <tr>
            <th scope="col">{t("kpis.machine")}</th>
            <th scope="col">{t("kpis.product")}</th>
            <th scope="col" class="num">
              {t("kpis.good")}
            </th>
            <th scope="col" class="num">
              {t("kpis.bad")}
            </th>
            <th scope="col" class="num">
              {t("kpis.ratio")}
            </th>
          </tr>
        </thead>
        <tbody>
          {lines.map((line) => (
            <tr key={`${line.machine} ${line.product}`}>
              <th scope="row">
                <Link kind="machine" id={line.machine} />
              </th>
              <td>{names.value(line.product)}</td>
              <Counts line={line} />
            </tr>
          ))}
        </tbody>
        <tfoot>
          <tr>
            <th scope="row" colSpan={2}>
              {t("kpis.allMachines")}
            </th>
            <Counts line={found} />
          </tr>
        </tfoot>
      </table>
    </div>
  );
}

type Counted = Pick<QualityAnswer, "good_quantity" | "scrap_quantity" | "quality_ratio">;

function Counts({ line }: { line: Counted }) {
  return (
    <>
      <td class="num">{format.count(line.good_quantity)}</td>
      <td class={line.scrap_quantity > 0 ? "num tone-warn" : "num"}>{format.count(line.scrap_quantity)}</td>
      <td class="num">{shownValue({ unit: "percent" }, line.quality_ratio)}</td>
    </>
  );
}
