import { signal, useComputed } from "@preact/signals";
import { nowS, world } from "../../../stream/stream";
import { t } from "../../../text/manager";
import { keyOf, strips, toneOf } from "./news";
import { newsText } from "./news-text";
import { CALLED, showNews } from "./show";

/** Those that were dismissed last: older ones are not shown any more anyway. */
const REMEMBERED = 20;

const dismissed = signal<ReadonlySet<string>>(new Set());

/** The newest news, laid over the map for some seconds: nothing moves to make room for them. */
export function NewsStrips() {
  const shown = useComputed(() => strips(world.value?.news.values() ?? [], nowS.value, dismissed.value)).value;
  return (
    <div class="strips" role="log" aria-label={t("news.region")}>
      {shown.map((news) => (
        <div key={keyOf(news)} class={`strip strip-${toneOf(news)}`}>
          <button type="button" class="strip-text" onClick={() => { showNews(news); }}>
            {newsText(news, nowS.value, CALLED)}
          </button>
          <button
            type="button"
            class="strip-close"
            aria-label={t("news.dismiss")}
            onClick={() => {
              dismissed.value = new Set([...[...dismissed.value].slice(-REMEMBERED), keyOf(news)]);
            }}
          >
            ×
          </button>
        </div>
      ))}
    </div>
  );
}
