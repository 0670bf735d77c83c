import { Icon } from "./Icon";
import { t } from "../text";
import { theme, THEMES } from "../theme/theme";

const ICONS = { system: "system", light: "sun", dark: "moon", paper: "paper" } as const;

export function ThemeSwitch() {
  return (
    <div class="segments icons" role="group" aria-label={t("theme.label")}>
      {THEMES.map((each) => (
        <button
          key={each}
          type="button"
          aria-pressed={theme.value === each}
          aria-label={t(`theme.${each}`)}
          title={t(`theme.${each}`)}
          onClick={() => {
            theme.value = each;
          }}
        >
          <Icon name={ICONS[each]} />
        </button>
      ))}
    </div>
  );
}
