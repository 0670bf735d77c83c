/** Products as master data: asked for by the view that defines them. */
import { csvOf, type FileBody } from "./file-body";
import { bodyOf, gateway } from "./gateway";
import type { components } from "./types";

type Schemas = components["schemas"];

/** All products, page after page. */
export async function fetchProducts(): Promise<Schemas["ProductAnswer"][]> {
  const found: Schemas["ProductAnswer"][] = [];
  let cursor: string | null = null;
  do {
    const query: { limit: number; cursor?: string } = cursor === null ? { limit: 200 } : { limit: 200, cursor };
    const page: { items: Schemas["ProductAnswer"][]; next_cursor: string | null } = await bodyOf(gateway.GET("/api/products", { params: { query } }));
    found.push(...page.items);
    cursor = page.next_cursor;
  } while (cursor !== null);
  return found;
}

/** @param etag of the revision that is changed; empty for a new product */
export async function defineProduct(product: string, draft: Schemas["ProductDraft"], etag: string): Promise<Schemas["ProductAnswer"]> {
  const header = etag === "" ? { "If-None-Match": "*" } : { "If-Match": etag };
  return await bodyOf(gateway.PUT("/api/products/{product}", { params: { path: { product }, header }, body: draft }));
}

/** What is in a file of products; unless it is a dry run, all of it is defined, or nothing. */
export async function importProducts(file: FileBody, dryRun: boolean): Promise<Schemas["ProductsAnswer"]> {
  return await bodyOf(gateway.POST("/api/products/import", { body: { ...csvOf(file), dry_run: dryRun } }));
}

/** Products that people have defined, also those that the plant does not fit any more; or the last removed ones. */
export async function fetchDefinitions(removed = false): Promise<Schemas["DefinitionAnswer"][]> {
  const found: Schemas["DefinitionAnswer"][] = [];
  let cursor: string | null = null;
  do {
    const query: { limit: number; removed: boolean; cursor?: string } = { limit: 200, removed, ...(cursor === null ? {} : { cursor }) };
    const page: { items: Schemas["DefinitionAnswer"][]; next_cursor: string | null } = await bodyOf(gateway.GET("/api/product-definitions", { params: { query } }));
    found.push(...page.items);
    cursor = page.next_cursor;
  } while (cursor !== null);
  return found;
}

/** @returns what became of each, in the same order */
export async function removeProducts(products: readonly string[]): Promise<readonly Schemas["RemovedProduct"][]> {
  return (await bodyOf(gateway.POST("/api/products/remove", { body: { products: [...products] } }))).products;
}
