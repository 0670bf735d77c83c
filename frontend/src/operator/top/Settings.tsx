import { soundRefusal, soundWanted, wantSound } from "../../alerts/sound";
import { LanguageSwitch } from "../../parts/LanguageSwitch";
import { ThemeSwitch } from "../../parts/ThemeSwitch";
import { t } from "../../text/operator";
import { leave } from "../session/session";

export function Settings() {
  return (
    <section class="settings" aria-label={t("settings.title")}>
      <LanguageSwitch />
      <ThemeSwitch />
      <label class="settings-sound">
        <input
          type="checkbox"
          checked={soundWanted.value}
          onChange={(event) => {
            const box = event.currentTarget;
            void wantSound(box.checked).then(() => { box.checked = soundWanted.value; });
          }}
        />
        <span>
          {t("settings.sound")}
          {soundRefusal.value !== "" && <small class="tone-warn" role="status">{t(`settings.${soundRefusal.value}`)}</small>}
        </span>
      </label>
      <a class="button" href="/login/station">
        {t("settings.station")}
      </a>
      <button type="button" class="button" onClick={() => void leave()}>
        {t("settings.logOut")}
      </button>
    </section>
  );
}
