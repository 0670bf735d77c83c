import { expect, test } from "vitest";
import { csvOf, fileBody } from "./file-body";

test("a file in UTF-8 is sent as its text, without its byte order mark", async () => {
  expect(csvOf(await fileBody(new Blob(["\ufeffMüller"])))).toEqual({ csv: "Müller" });
});

test("a file in another encoding is sent as it is, so that no letter of it is lost", async () => {
  const windows = new Uint8Array([0x4d, 0xfc]);
  const wide = new Uint8Array([0x4d, 0, 0x75, 0]);
  expect(csvOf(await fileBody(new Blob([windows])))).toEqual({ base64: "Tfw=" });
  expect(csvOf(await fileBody(new Blob([wide])))).toEqual({ base64: "TQB1AA==" });
});
