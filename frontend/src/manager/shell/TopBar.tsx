import { AlertsTag } from "../alerts/AlertsTag";
import { world } from "../../stream/stream";
import { format, t } from "../../text/manager";
import { PersonMenu } from "./PersonMenu";
import { view, VIEWS } from "../views";
import { LiveTag } from "../../parts/LiveTag";

export function TopBar() {
  const speed = world.value?.factory.speed ?? 1;
  const shown = format.number(speed, speed % 1 === 0 ? 0 : 1);
  return (
    <header class="top">
      <a class="logo" href="#plant">
        <i aria-hidden="true" />
        Dray
      </a>
      <nav aria-label={t("nav.label")}>
        {VIEWS.filter((name) => name !== "alerts").map((name) => (
          <a key={name} href={`#${name}`} aria-current={view.value === name ? "page" : undefined}>
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
        <AlertsTag />
        <PersonMenu />
      </div>
    </header>
  );
}
