import { type Freshness, isPast } from "../../stream/freshness";
import { ageS, freshness, reconnect } from "../../stream/stream";
import { format, t } from "../../text/operator";
import { ended } from "../session/session";

/** Says why not everything works, and what still does; nothing while all is well. */
export function Banner() {
  if (ended.value !== null) {
    return (
      <div class={`banner ${ended.value === "taken_back" ? "" : "banner-calm"}`} role="alert">
        <span>{t(`banner.ended.${ended.value}`)}</span>
        <a class="button" href={`/login?next=${encodeURIComponent(location.pathname)}`}>
          {t("banner.logIn")}
        </a>
      </div>
    );
  }
  const state = freshness.value;
  if (!isPast(state)) return null;
  return (
    <div class="banner" role="alert">
      <span>
        {pastText(state, ageS.value)} {t("banner.inDanger")}
      </span>
      <button type="button" class="button" onClick={reconnect}>
        {t("live.retry")}
      </button>
    </div>
  );
}

function pastText(state: Freshness, oldS: number | null): string {
  if (oldS === null) return t("banner.offlineEmpty");
  return t(state === "stale" ? "banner.stale" : "banner.offline", { age: format.age(oldS) });
}
