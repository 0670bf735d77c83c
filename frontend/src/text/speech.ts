/**
 * The language that the page speaks now. Components that read a text are drawn anew when it changes.
 *
 * A panel brings the tables of its languages as functions, so that only one of them is loaded.
 */
import { computed, signal } from "@preact/signals";
import { bring } from "../api/bring";
import { fill, type Table, type Texts } from "./catalogue";
import { type Formats, formatsFor } from "./format";
import { type Language, languageOf, localeFor, rememberLanguage } from "./language";

export type Tables = Readonly<Record<Language, () => Promise<Table>>>;

interface Speech {
  readonly language: Language;
  readonly table: Table;
  readonly rules: Intl.PluralRules;
  readonly formats: Formats;
}

const speech = signal(speechOf("en", {}, "en-GB"));
let tables: Tables | null = null;
/** What views say that are loaded when somebody looks at them. */
const more = new Set<Tables>();
/** The language that was asked for last; `language` is it as soon as its words are there. */
let wanted: Language = "en";
let turns = 0;
let latest: Promise<void> = Promise.resolve();

export const language = computed(() => speech.value.language);

/** Loads the language that was chosen here before, or else the browser's. To be awaited before anything is shown. */
export async function beginToSpeak(known: Tables): Promise<void> {
  tables = known;
  wanted = languageOf(document.cookie, navigator.languages);
  await untilLoaded();
}

/** Loads what a view says beside its panel; from then on it follows the language. */
export async function speakAlso(known: Tables): Promise<void> {
  more.add(known);
  await load();
}

/** Goes on in another language, here and on the server's pages, from now on. */
export async function changeLanguage(to: Language): Promise<void> {
  rememberLanguage(to);
  wanted = to;
  await untilLoaded();
}

/** Speaks from this table at once. */
export function speak(to: Language, table: Table, locale: string): void {
  speech.value = speechOf(to, table, locale);
}

/** What a panel says; the type is that of its English table. */
export function textsOf<English extends Table>(): Texts<English> {
  const message = (key: PropertyKey): string | undefined => speech.value.table[key as string];
  return {
    t: (key, ...args) => fill(message(key) ?? "", args[0] ?? {}),
    n: (stem, count, shown = String(count)) => {
      const form = speech.value.rules.select(count);
      return fill(message(`${stem}.${form}`) ?? message(`${stem}.other`) ?? "", { n: shown });
    },
    word: (group, word) => message(`${group}.${word}`) ?? word.replaceAll("_", " "),
  };
}

/** Numbers, times and lengths of time in the page's language. */
export const format: Formats = {
  percent: (frac, digits) => speech.value.formats.percent(frac, digits),
  count: (value) => speech.value.formats.count(value),
  number: (value, digits) => speech.value.formats.number(value, digits),
  duration: (seconds) => speech.value.formats.duration(seconds),
  price: (seconds) => speech.value.formats.price(seconds),
  age: (seconds) => speech.value.formats.age(seconds),
  clock: (atS) => speech.value.formats.clock(atS),
  hour: (atS) => speech.value.formats.hour(atS),
  day: (atS) => speech.value.formats.day(atS),
  moment: (atS) => speech.value.formats.moment(atS),
  dated: (atS) => speech.value.formats.dated(atS),
  span: (fromS, untilS) => speech.value.formats.span(fromS, untilS),
  due: (atS, nowS) => speech.value.formats.due(atS, nowS),
  when: (atS, nowS) => speech.value.formats.when(atS, nowS),
  list: (items) => speech.value.formats.list(items),
};

/** Words are waited for, however long the network is away: without them nothing can be shown. */
function untilLoaded(): Promise<void> {
  return new Promise((resolve) => { bring(load, resolve); });
}

/** Of several that load at the same time the last one speaks: it knows all that the others load, and each waits for it. */
function load(): Promise<void> {
  return latest = speakFully();
}

async function speakFully(): Promise<void> {
  const turn = ++turns;
  const to = wanted;
  const table = await tables?.[to]();
  if (!table) return;
  const others = await Promise.all([...more].map((each) => each[to]()));
  if (turn !== turns) return latest;
  speak(to, Object.assign({}, table, ...others) as Table, localeFor(to, navigator.languages));
  document.documentElement.lang = to;
}

function speechOf(to: Language, table: Table, locale: string): Speech {
  return { language: to, table, rules: new Intl.PluralRules(locale), formats: formatsFor(locale) };
}
