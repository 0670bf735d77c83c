import { Icon } from "../../parts/Icon";
import { LanguageSwitch } from "../../parts/LanguageSwitch";
import { ThemeSwitch } from "../../parts/ThemeSwitch";
import { t, word } from "../../text/manager";
import { Later } from "../../parts/Later";
import { begin } from "../story/tour";
import { go } from "../views";
import { failed, leave, me } from "./session";

/** Who works here, what may be chosen for this browser, and the way out. */
export function PersonMenu() {
  const person = me.value;
  const role = person && word("person.role", person.role ?? person.kind);
  return (
    <>
      <button type="button" class="button person" popovertarget="person-menu">
        <span class="clip" title={person?.name}>{person?.name ?? t("person.menu")}</span>
        <Icon name="down" />
      </button>
      <section id="person-menu" class="card person-menu" popover="auto" aria-label={t("person.menu")}>
        {person && (
          <p>
            <b>{person.name}</b>
            {role !== person.name && <small class="line muted">{role}</small>}
          </p>
        )}
        <div class="person-choice">
          <span>{t("language.label")}</span>
          <LanguageSwitch />
        </div>
        <div class="person-choice">
          <span>{t("theme.label")}</span>
          <ThemeSwitch />
        </div>
        <Later load={async () => (await import("../alerts/telling/Telling")).load()} />
        {person?.scopes.includes("people:write") && (
          <button type="button" class="button" popovertarget="person-menu" popovertargetaction="hide" onClick={() => { go("people"); }}>
            {t("nav.people")}
          </button>
        )}
        <a class="button" href="/operator">{t("nav.operator")}</a>
        <button type="button" class="button" popovertarget="person-menu" popovertargetaction="hide" onClick={() => { begin(); go("plant"); }}>
          {t("tour.again")}
        </button>
        <button type="button" class="button" onClick={() => void leave()}>
          {t("person.logOut")}
        </button>
        {failed.value !== "" && (
          <small class="line" role="alert">
            {failed.value}
          </small>
        )}
      </section>
    </>
  );
}
