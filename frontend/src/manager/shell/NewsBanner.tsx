import { isPast } from "../../stream/freshness";
import { ageS, freshness, reconnect } from "../../stream/stream";
import { format, t } from "../../text/manager";

/** Says that the picture is old, over the whole width, until it is not. */
export function NewsBanner() {
  const state = freshness.value;
  if (!isPast(state)) return null;
  const age = ageS.value === null ? null : format.age(ageS.value);
  return (
    <div class="banner" role="alert">
      <span>{age === null ? t("live.offlineEmpty") : t(`live.${state === "stale" ? "stale" : "offline"}Banner`, { age })}</span>
      <button type="button" class="button small" onClick={reconnect}>
        {t("live.retry")}
      </button>
    </div>
  );
}
