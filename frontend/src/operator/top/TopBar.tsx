import { signal } from "@preact/signals";
import { Icon } from "../../parts/Icon";
import { LiveTag } from "../../parts/LiveTag";
import { format, t } from "../../text/operator";
import { duty } from "../duty/duty";
import { me } from "../session/session";
import { moment, placeName, station } from "../state";
import { Settings } from "./Settings";

const open = signal(false);

/** Where this is and who works here. What it opens pushes the page down, and covers nothing. */
export function TopBar() {
  const speed = moment.value.speed;
  const shown = format.number(speed, speed % 1 === 0 ? 0 : 1);
  const machine = station.value;
  return (
    <>
      <header class="top">
        <div class="top-where">
          <h1 class="clip">{machine ? t("top.station", { id: machine.id, name: machine.name }) : placeName.value}</h1>
          {machine && <p class="muted clip">{placeName.value}</p>}
        </div>
        <div class="top-right">
          {speed !== 1 && (
            <span class="tag top-speed" title={t("speed.title", { speed: shown })}>
              {t("speed.tag", { speed: shown })}
            </span>
          )}
          <LiveTag />
          <ToDuty />
          <span class="top-who clip">{me.value?.name}</span>
          <button
            type="button"
            class="button settings-button"
            aria-label={t("settings.title")}
            aria-expanded={open.value}
            onClick={() => {
              open.value = !open.value;
            }}
          >
            <Icon name="settings" />
          </button>
        </div>
      </header>
      {open.value && <Settings />}
    </>
  );
}

/** Whether this person is on duty, under what it is about: a state alone would read like a deed. It leads to where that is changed. */
function ToDuty() {
  const state = duty.value?.state;
  if (state === undefined) return null;
  return (
    <button
      type="button"
      class={`button top-duty ${state === "on" ? "" : "quiet"}`}
      onClick={() => {
        const card = document.getElementById("duty");
        card?.scrollIntoView({ block: "center" });
        card?.querySelector("button")?.focus({ preventScroll: true });
      }}
    >
      <small>{t("duty.mine")}</small> <b>{t(`duty.${state}`)}</b> <span class="unseen">{t("duty.change")}</span>
    </button>
  );
}
