/**
 * The page's language. English is complete; German and Spanish join `LANGUAGES` as further tables.
 */
import { type Catalogue, textsFrom } from "./catalogue";
import { en } from "./en";
import { formatsFor } from "./format";

const LANGUAGES: Readonly<Record<string, Catalogue>> = { en };

/** The first wanted locale that we speak; regional forms keep their own numbers and dates. */
export function chooseLocale(wanted: readonly string[]): string {
  return wanted.find((locale) => (locale.split("-")[0] ?? "") in LANGUAGES) ?? "en-GB";
}

// Unit tests run without a browser.
const locale = chooseLocale(typeof navigator === "undefined" ? [] : navigator.languages);
const catalogue = LANGUAGES[locale.split("-")[0] ?? ""] ?? en;

export const { t, n, word } = textsFrom(catalogue, locale);
/** A bare "en" would write dates the American way, which nobody outside expects. */
export const format = formatsFor(locale === "en" ? "en-GB" : locale);
