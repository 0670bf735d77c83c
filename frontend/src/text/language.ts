/** Which language a page speaks: the one that was chosen, else the first wanted one that we speak. */

export const LANGUAGES = ["en", "de", "es"] as const;
export type Language = (typeof LANGUAGES)[number];

/** What the languages call themselves. */
export const OWN_NAMES: Readonly<Record<Language, string>> = { en: "English", de: "Deutsch", es: "Español" };

/** The server's pages read it, too. */
const COOKIE = "dray_language";
const REMEMBERED_S = 365 * 86_400;

/** A bare "en" would write dates the American way, which nobody outside expects. */
const LOCALES: Readonly<Record<Language, string>> = { en: "en-GB", de: "de-DE", es: "es-ES" };

/**
 * @param cookies as `document.cookie` has them
 * @param wanted locales, the dearest first
 */
export function languageOf(cookies: string, wanted: readonly string[]): Language {
  const chosen = cookies.split("; ").find((each) => each.startsWith(`${COOKIE}=`));
  return [chosen?.slice(COOKIE.length + 1) ?? "", ...wanted].map(ours).find((each) => each !== null) ?? "en";
}

/** The wanted regional form of a language, which keeps its own numbers and dates. */
export function localeFor(language: Language, wanted: readonly string[]): string {
  return wanted.find((locale) => ours(locale) === language && locale.includes("-")) ?? LOCALES[language];
}

export function rememberLanguage(language: Language): void {
  const secure = location.protocol === "https:" ? "; Secure" : "";
  document.cookie = `${COOKIE}=${language}; Path=/; Max-Age=${REMEMBERED_S}; SameSite=Lax${secure}`;
}

function ours(locale: string): Language | null {
  return LANGUAGES.find((each) => each === locale.split("-")[0]?.toLowerCase()) ?? null;
}
