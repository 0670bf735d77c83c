import { ageS, freshness } from "../stream/stream";
import { format, t } from "../text";

/** How old the picture is; its width never changes. */
export function LiveTag() {
  const state = freshness.value;
  const tone = { live: "normal", connecting: "normal", amber: "warn", stale: "alarm", offline: "alarm" }[state];
  return (
    <span class={`tag tag-${tone} live`} title={t("live.title")}>
      <i class={`live-dot live-${state}`} aria-hidden="true" />
      <span>{t(`live.${state}`)}</span>
      <span class="num live-age">{ageS.value === null ? "" : format.age(ageS.value)}</span>
    </span>
  );
}
