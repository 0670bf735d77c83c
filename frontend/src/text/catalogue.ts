/**
 * Messages with typed keys and typed parameters. A language is a table with the keys of `en`; a
 * missing one is a type error, so no panel can ever show a bare key.
 */
import { en } from "./en";

export type Key = keyof typeof en;
export type Catalogue = Readonly<Record<Key, string>>;

/** The names in braces in a message. */
type Names<Message extends string> = Message extends `${string}{${infer Name}}${infer Rest}`
  ? Name | Names<Rest>
  : never;
export type Params<K extends Key> = Readonly<Record<Names<(typeof en)[K]>, string | number>>;
type Args<K extends Key> = [Names<(typeof en)[K]>] extends [never] ? [] : [Params<K>];

/** Keys that come as `….one` and `….other`, for counts. */
export type Plural = Key extends infer K ? (K extends `${infer Stem}.other` ? Stem : never) : never;

export interface Texts {
  readonly locale: string;
  t: <K extends Key>(key: K, ...args: Args<K>) => string;
  /** A message that depends on a number, which stands in it as `{n}`. */
  n: (stem: Plural, count: number, shown?: string) => string;
  /** A word that the server chose, or the word itself where this version does not know it. */
  word: (group: string, word: string) => string;
}

export function textsFrom(catalogue: Catalogue, locale: string): Texts {
  const rules = new Intl.PluralRules(locale);
  const table: Readonly<Partial<Record<string, string>>> = catalogue;
  return {
    locale,
    t: (key, ...args) => fill(catalogue[key], args[0] ?? {}),
    n: (stem, count, shown = String(count)) => {
      const message = table[`${stem}.${rules.select(count)}`] ?? table[`${stem}.other`] ?? "";
      return fill(message, { n: shown });
    },
    word: (group, word) => table[`${group}.${word}`] ?? word.replaceAll("_", " "),
  };
}

function fill(message: string, params: Readonly<Record<string, string | number>>): string {
  return message.replace(/\{(\w+)\}/g, (whole, name: string) => String(params[name] ?? whole));
}
