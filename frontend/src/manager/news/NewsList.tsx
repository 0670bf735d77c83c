import { nowS, world } from "../../stream/stream";
import { format, t } from "../../text/manager";
import { keyOf, lately, toneOf } from "./news";
import { newsText } from "./news-text";
import { CALLED, showNews } from "./show";

/** What has happened lately, newest first. */
export function NewsList({ done }: { done: () => void }) {
  const news = lately(world.value?.news.values() ?? []);
  return (
    <>
      <h2>{t("news.title")}</h2>
      {news.length === 0 && <p class="empty">{t("news.none")}</p>}
      <ul>
        {news.map((each) => (
          <li key={keyOf(each)}>
            <button
              type="button"
              class={`alert news-${toneOf(each)}`}
              onClick={() => {
                showNews(each);
                done();
              }}
            >
              <i aria-hidden="true" />
              <span class="news-line">{newsText(each, nowS.value, CALLED)}</span>
              <span class="alert-text">{t("machine.ago", { age: format.age(nowS.value - each.at_s) })}</span>
            </button>
          </li>
        ))}
      </ul>
    </>
  );
}
