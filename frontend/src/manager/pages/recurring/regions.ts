/** Countries and their regions, whose public holidays recurring work leaves out. */

/** Codes that browsers have names for, and that are no countries with holidays of their own. */
const NO_COUNTRIES: ReadonlySet<string> = new Set(["AC", "CP", "CQ", "DG", "EA", "EU", "EZ", "IC", "QO", "TA", "UN", "XA", "XB", "ZZ"]);

const LETTERS = Array.from("ABCDEFGHIJKLMNOPQRSTUVWXYZ");

export interface Country {
  readonly code: string;
  readonly name: string;
}

/** All countries, by their names in a language. */
export function countries(language: string): Country[] {
  const names = namesIn(language);
  return LETTERS.flatMap((first) => LETTERS.map((second) => first + second))
    // A code that was given up stands for another one now.
    .filter((code) => !NO_COUNTRIES.has(code) && new Intl.Locale(`und-${code}`).region === code)
    .map((code) => ({ code, name: names.of(code) ?? "" }))
    .filter(({ name }) => name !== "")
    .sort((a, b) => a.name.localeCompare(b.name, language));
}

/** A region as people read it: the country by its name, a part of it by its code. */
export function regionName(region: string, language: string): string {
  const [country = "", ...part] = region.split("-");
  const name = /^[A-Z]{2}$/.test(country) ? namesIn(language).of(country) : undefined;
  if (name === undefined) return region;
  return part.length === 0 ? name : `${name} (${part.join("-")})`;
}

function namesIn(language: string): Intl.DisplayNames {
  return new Intl.DisplayNames(language, { type: "region", fallback: "none" });
}
