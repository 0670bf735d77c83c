/**
 * Messages with typed keys and typed parameters. English says which messages there are; every other
 * language is a table with the same keys, and a missing one is a type error.
 */

export type Table = Readonly<Record<string, string>>;
/** A language of a panel whose English is `English`. */
export type Catalogue<English extends Table> = Readonly<Record<keyof English, string>>;

/** The names in braces in a message. */
type Names<Message extends string> = Message extends `${string}{${infer Name}}${infer Rest}`
  ? Name | Names<Rest>
  : never;
type Args<Message extends string> = [Names<Message>] extends [never]
  ? []
  : [Readonly<Record<Names<Message>, string | number>>];

/** Keys that come as `….one` and `….other`, for counts. */
type Plural<Key> = Key extends `${infer Stem}.other` ? Stem : never;

export interface Texts<English extends Table> {
  t: <K extends keyof English>(key: K, ...args: Args<English[K] & string>) => string;
  /** A message that depends on a number, which stands in it as `{n}`. */
  n: (stem: Plural<keyof English>, count: number, shown?: string) => string;
  /** A word that the server chose, or the word itself where this version does not know it. */
  word: (group: string, word: string) => string;
}

/** A message with its names filled in. */
export function fill(message: string, params: Readonly<Record<string, string | number>>): string {
  return message.replace(/\{(\w+)\}/g, (whole, name: string) => String(params[name] ?? whole));
}
