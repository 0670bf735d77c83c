import { t } from "../text";
import { type Language, LANGUAGES, OWN_NAMES } from "../text/language";
import { changeLanguage, language } from "../text/speech";

export function LanguageSwitch() {
  return (
    <select
      class="language"
      aria-label={t("language.label")}
      value={language.value}
      onChange={(event) => void changeLanguage(event.currentTarget.value as Language)}
    >
      {LANGUAGES.map((each) => (
        <option key={each} value={each} lang={each}>
          {OWN_NAMES[each]}
        </option>
      ))}
    </select>
  );
}
