import { AlertsTag } from "../alerts/AlertsTag";
import { world } from "../../stream/stream";
import { format, t } from "../../text/manager";
import { PersonMenu } from "./PersonMenu";
import { LED_TO, MENU, view } from "../views";
import { Icon } from "../../parts/Icon";
import { LiveTag } from "../../parts/LiveTag";

export function TopBar() {
  const speed = world.value?.factory.speed ?? 1;
  const shown = format.number(speed, speed % 1 === 0 ? 0 : 1);
  const above = view.value in LED_TO ? LED_TO[view.value as keyof typeof LED_TO] : null;
  return (
    <header class="top">
      <a class="logo" href="#plant">
        <i aria-hidden="true" />
        Dray
      </a>
      <nav aria-label={t("nav.label")}>
        {MENU.map((name) => (
          <a key={name} href={`#${name}`} aria-current={view.value === name ? "page" : name === above ? "true" : undefined}>
            {t(`nav.${name}`)}
          </a>
        ))}
        <a href="/editor">{t("nav.editor")}</a>
      </nav>
      <div class="top-right">
        {speed !== 1 && (
          <span class="tag" title={t("speed.title", { speed: shown })}>
            {t("speed.tag", { speed: shown })}
          </span>
        )}
        <LiveTag />
        <a class="moment-link" href="#replay" aria-label={t("nav.replay")} title={t("nav.replay")} aria-current={view.value === "replay" ? "page" : undefined}>
          <Icon name="past" />
        </a>
        <AlertsTag />
        <PersonMenu />
      </div>
    </header>
  );
}
