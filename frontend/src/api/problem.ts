/** Why a request did not succeed: the gateway's problems (RFC 9457), and those of the way to it, as values. */
import type { FieldError } from "./types";

/** The kind of a problem with `status` 0 where there was no way to the gateway at all. */
export const NOT_SENT = "not-sent";

/** `status` 0: no answer came, or none that can be read. */
export class Problem extends Error {
  constructor(
    readonly status: number,
    title: string,
    readonly errors: readonly FieldError[] = [],
    /** Its short name, as `unknown-order`; empty where the answer has none. */
    readonly kind = "",
  ) {
    super(title);
    this.name = "Problem";
  }
}

/** Whatever the answer holds, it becomes a problem: a proxy may send HTML. */
export function problemOf(status: number, answer: unknown): Problem {
  const body = (typeof answer === "object" && answer !== null ? answer : {}) as Record<string, unknown>;
  const title = [body.detail, body.title].find((text) => typeof text === "string" && text !== "");
  const errors = Array.isArray(body.errors) ? body.errors.filter(isFieldError) : [];
  const kind = typeof body.type === "string" ? (body.type.split(":").at(-1) ?? "") : "";
  return new Problem(status, typeof title === "string" ? title : `HTTP ${status}`, errors, kind);
}

function isFieldError(value: unknown): value is FieldError {
  const error = value as Partial<Record<string, unknown>> | null;
  return typeof error?.field === "string" && typeof error.reason === "string";
}
