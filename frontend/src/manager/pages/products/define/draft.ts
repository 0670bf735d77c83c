/** A product as somebody writes it: rows of text, which become a definition. */
import type { components } from "../../../../api/types";

export type ProductAnswer = components["schemas"]["ProductAnswer"];
export type ProductDraft = components["schemas"]["ProductDraft"];

/** A row of the bill, or a machine: what, and how much of it. */
export interface Amount {
  readonly what: string;
  readonly amount: string;
}

export interface Paper {
  readonly name: string;
  readonly address: string;
  readonly media_type: string;
  readonly sha256: string;
}

export interface Written {
  readonly id: string;
  readonly name: string;
  readonly lot: string;
  readonly ability: string;
  readonly bill: readonly Amount[];
  readonly machines: readonly Amount[];
  readonly documents: readonly Paper[];
  /** The `ETag` of the revision that is changed; empty for a new product. */
  readonly etag: string;
}

export const NO_AMOUNT: Amount = { what: "", amount: "" };
export const NO_PAPER: Paper = { name: "", address: "", media_type: "application/pdf", sha256: "" };

export function empty(ability: string): Written {
  return { id: "", name: "", lot: "", ability, bill: [NO_AMOUNT], machines: [NO_AMOUNT], documents: [], etag: "" };
}

export function writtenOf(product: ProductAnswer): Written {
  const amounts = (of: Readonly<Record<string, number>>) => Object.entries(of).map(([what, amount]) => ({ what, amount: String(amount) }));
  return {
    id: product.id,
    name: product.name,
    lot: String(product.lot),
    ability: product.ability,
    bill: amounts(product.bill),
    machines: amounts(product.machines),
    documents: product.documents.map(({ address, media_type, name, sha256 }) => ({ address, media_type, name, sha256 })),
    etag: `"${product.revision}"`,
  };
}

/** What is sent. What is no number goes as it was written, for the gateway says best what is wrong with it. */
export function draftOf(written: Written): ProductDraft {
  const amounts = (rows: readonly Amount[]) =>
    Object.fromEntries(rows.filter(({ what }) => what !== "").map(({ amount, what }) => [what, numberOf(amount)]));
  return {
    name: written.name.trim(),
    lot: numberOf(written.lot),
    ability: written.ability,
    bill: amounts(written.bill),
    machines: amounts(written.machines),
    documents: written.documents.map((paper) => ({ ...paper, name: paper.name.trim(), address: paper.address.trim(), sha256: paper.sha256.trim().toLowerCase() })),
  };
}

function numberOf(text: string): number {
  const trimmed = text.trim().replace(",", ".");
  return trimmed !== "" && Number.isFinite(Number(trimmed)) ? Number(trimmed) : (text as unknown as number);
}

/** Materials or machines that stand in two rows: the later would silently replace the earlier. */
export function twice(rows: readonly Amount[]): string | null {
  const named = rows.map(({ what }) => what).filter((what) => what !== "");
  return named.find((what, i) => named.indexOf(what) < i) ?? null;
}

/** At which part of the form a complaint of the gateway is shown, as `bill`, `documents.2` or `lot`; empty for the whole form. */
export function partOf(field: string, written: Written): string {
  const [head = "", rest = ""] = field.replace(/\[(\d+)\]/g, ".$1").split(/\.(.*)/s);
  if (head === "documents") {
    const index = rest.split(".")[0] ?? "";
    return index === "" ? "documents" : `documents.${index}`;
  }
  if (head === "bill" || head === "machines") {
    const [first = ""] = rest.split(".");
    const named = written[head].filter(({ what }) => what !== "")[Number(first)];
    const index = written[head].findIndex((row) => (/^\d+$/.test(first) ? row === named : row.what === rest.replace(".[key]", "")));
    return index < 0 ? head : `${head}.${index}`;
  }
  return ["name", "lot", "ability", "product"].includes(head) ? (head === "product" ? "id" : head) : "";
}

/** The SHA-256 of a file in hexadecimal digits. */
export async function sha256Of(file: Blob): Promise<string> {
  const digest = await crypto.subtle.digest("SHA-256", await file.arrayBuffer());
  return Array.from(new Uint8Array(digest), (byte) => byte.toString(16).padStart(2, "0")).join("");
}
