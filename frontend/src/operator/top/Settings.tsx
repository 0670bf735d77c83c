import { LanguageSwitch } from "../../parts/LanguageSwitch";
import { ThemeSwitch } from "../../parts/ThemeSwitch";
import { t } from "../../text/operator";

export function Settings() {
  return (
    <section class="settings" aria-label={t("settings.title")}>
      <LanguageSwitch />
      <ThemeSwitch />
      <form method="post" action="/logout">
        <button type="submit" class="button">
          {t("settings.logOut")}
        </button>
      </form>
    </section>
  );
}
