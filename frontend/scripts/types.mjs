// Writes generated/openapi.ts, the types of all that the gateway is asked and answers, from its OpenAPI document.
// Nobody keeps them: type check and linter make them anew, so panels that do not fit the gateway fail there.
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import openapiTS, { astToString } from "openapi-typescript";

const here = (path) => fileURLToPath(new URL(path, import.meta.url));
const venv = here("../../.venv/bin/python");
const python = process.env.DRAY_PYTHON ?? (existsSync(venv) ? venv : "python3");

const document = execFileSync(python, [here("openapi.py")], {
  env: { ...process.env, PYTHONPATH: here("../../backend") },
  encoding: "utf8",
  maxBuffer: 1 << 26,
});
const types = await openapiTS(document, {
  // A field of a request that has a default may be left out.
  defaultNonNullable: false,
  // What a fault or an audit line tells depends on its kind.
  emptyObjectsUnknown: true,
  rootTypes: true,
  rootTypesNoSchemaPrefix: true,
});
mkdirSync(here("../generated"), { recursive: true });
writeFileSync(here("../generated/openapi.ts"), astToString(types));
