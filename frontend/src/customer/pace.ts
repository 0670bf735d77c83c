/** When to ask for news again, and what to say while there is no answer. Pure. */

/** An address that failed so often is shown as "no connection": one lost answer is no news to anybody. */
const FAILURES_SHOWN = 2;

/** The longest pause: a customer who comes back to the page should not wait longer for it to recover. */
const LONGEST_S = 60;

/** @returns seconds until the next question, after so many failures in a row */
export function pauseS(pollS: number, failures: number): number {
  return Math.min(LONGEST_S, pollS * 2 ** Math.min(failures, 10));
}

export function isOffline(failures: number): boolean {
  return failures >= FAILURES_SHOWN;
}

/** A sentence of the server's with the time in it. */
export function withTime(sentence: string, time: string): string {
  return sentence.replace("{time}", time);
}

/** How the server learns in which time zone the reader is, from the next request on. */
export function zoneCookie(zone: string, secure: boolean): string {
  return `dray.zone=${zone}; path=/track; max-age=31536000; samesite=lax${secure ? "; secure" : ""}`;
}
