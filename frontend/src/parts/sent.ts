/** The rule of every form that stays after it was sent: what somebody has written since is kept, the rest makes room. Pure. */

/** A field after the answer: `after`, unless it was changed since it was sent. */
export function afterSent<T>(sent: T, now: T, after: T): T {
  return now === sent ? after : now;
}

/** All fields of a form, each by itself. */
export function fieldsAfterSent<T extends object>(sent: T, now: T, after: T): T {
  const fields = Object.keys(after) as (keyof T)[];
  return Object.fromEntries(fields.map((field) => [field, afterSent(sent[field], now[field], after[field])])) as T;
}
