import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { askAgain } from "../../api/ask-again";
import { fetchQuality } from "../../api/client";
import type { QualityAnswer } from "../../api/types";
import { nowS } from "../../stream/stream";
import { speakAlso } from "../../text/speech";
import { format, t, tables } from "../../text/views/pieces";
import "./pieces.css";

/** A shift. */
const SPAN_S = 8 * 3600;
/** Each piece is counted within seconds. */
const AGAIN_MS = 30_000;

interface Props {
  readonly machine: string;
  readonly name: (product: string) => string;
}

/** The part, once it has its words. */
export async function load(): Promise<typeof Pieces> {
  await speakAlso(tables);
  return Pieces;
}

/** The good and bad pieces of one machine, and its quality ratio, by product. Nothing before they are known. */
function Pieces({ machine, name }: Props) {
  const found = useSignal<QualityAnswer | null>(null);
  useEffect(() => {
    found.value = null;
    return askAgain(() => fetchQuality(nowS.peek() - SPAN_S, machine), (answer) => { found.value = answer; }, AGAIN_MS);
  }, [found, machine]);
  if (found.value === null) return null;
  const { items, since_at_s: sinceS } = found.value;
  const since = format.hour(sinceS);
  if (items.length === 0) return <p class="pieces muted">{t("pieces.none", { since })}</p>;
  return (
    <table class="pieces">
      <caption>{t("pieces.since", { since })}</caption>
      <thead>
        <tr>
          <th scope="col">{t("pieces.product")}</th>
          <th scope="col">{t("pieces.good")}</th>
          <th scope="col">{t("pieces.bad")}</th>
          <th scope="col">{t("pieces.ratio")}</th>
        </tr>
      </thead>
      <tbody>
        {items.map(({ good_quantity: good, product, quality_ratio: ratio, scrap_quantity: bad }) => (
          <tr key={product}>
            <th scope="row">{name(product)}</th>
            <td class="num">{format.count(good)}</td>
            <td class={`num ${bad > 0 ? "tone-warn" : ""}`}>{format.count(bad)}</td>
            <td class="num">{format.percent(ratio, 1)}</td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}
