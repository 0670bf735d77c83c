import { nowS, world } from "../../../stream/stream";
import { format, t } from "../../../text/manager";
import { MomentLink } from "../../replay/MomentLink";
import { keyOf, lately, toneOf } from "./news";
import { newsText } from "./news-text";
import { CALLED, showNews } from "./show";

/** What has happened lately, newest first. */
export function NewsList() {
  const news = lately(world.value?.news.values() ?? []);
  return (
    <section class="card news" aria-labelledby="news">
      <header class="card-head">
        <h2 id="news">{t("news.title")}</h2>
      </header>
      {news.length === 0 && <p class="empty">{t("news.none")}</p>}
      <ul class="news-list">
        {news.map((each) => (
          <li key={keyOf(each)}>
            <button type="button" class={`news-line news-${toneOf(each)}`} onClick={() => { showNews(each); }}>
              <i aria-hidden="true" />
              <span>{newsText(each, nowS.value, CALLED)}</span>
              <span class="faint num">{t("machine.ago", { age: format.age(nowS.value - each.at_s) })}</span>
            </button>
            <MomentLink atS={each.at_s} about={newsText(each, nowS.value, CALLED)} />
          </li>
        ))}
      </ul>
    </section>
  );
}
