import { LanguageSwitch } from "../../parts/LanguageSwitch";
import { ThemeSwitch } from "../../parts/ThemeSwitch";
import { t } from "../../text/operator";
import { leave } from "../session/session";

export function Settings() {
  return (
    <section class="settings" aria-label={t("settings.title")}>
      <LanguageSwitch />
      <ThemeSwitch />
      <button type="button" class="button" onClick={() => void leave()}>
        {t("settings.logOut")}
      </button>
    </section>
  );
}
