import { format, t } from "../../../text/manager";
import { sparkPoints } from "./spark";

const WIDTH = 72;
const HEIGHT = 16;

/** Deliveries per hour over the last hour, with the newest figure in words. */
export function Sparkline({ values }: { values: readonly number[] }) {
  const points = sparkPoints(values, WIDTH, HEIGHT);
  const now = values.at(-1) ?? 0;
  const last = points.at(-1);
  const label = t("factory.deliveriesLabel", {
    now: format.count(now),
    most: format.count(Math.max(0, ...values)),
  });
  return (
    <div class="spark">
      <span>{t("factory.deliveries")}</span>
      <svg role="img" aria-label={label} width={WIDTH + 8} height={HEIGHT + 8} viewBox={`-4 -4 ${WIDTH + 8} ${HEIGHT + 8}`}>
        <line x1="0" y1={HEIGHT} x2={WIDTH} y2={HEIGHT} class="spark-base" />
        <polyline points={points.map((point) => point.join(",")).join(" ")} class="spark-line" />
        {last && <circle cx={last[0]} cy={last[1]} r="2.5" class="spark-dot" />}
      </svg>
      <b>{values.length > 0 ? format.count(now) : t("factory.none")}</b>
    </div>
  );
}
