/** A file as a request holds it. */

/** Its text where it is UTF-8; else its bytes in base64, of which the gateway finds out the encoding. */
export type FileBody = { readonly text: string } | { readonly base64: string };

export async function fileBody(file: Blob): Promise<FileBody> {
  const bytes = new Uint8Array(await file.arrayBuffer());
  try {
    const text = new TextDecoder("utf-8", { fatal: true }).decode(bytes);
    // UTF-16 without a byte order mark is UTF-8, too, with a zero behind each letter.
    if (!text.includes("\0")) return { text };
  } catch {
    // It is no UTF-8.
  }
  return { base64: base64Of(bytes) };
}

export function base64Of(bytes: Uint8Array): string {
  let binary = "";
  for (const byte of bytes) binary += String.fromCharCode(byte);
  return btoa(binary);
}

/** The fields of an import of a spreadsheet. */
export function csvOf(body: FileBody): { csv: string } | { base64: string } {
  return "text" in body ? { csv: body.text } : body;
}
