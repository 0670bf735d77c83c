/** The plant editor's page: a part of the management panel with a script of its own. */
import "@fontsource-variable/inter/wght.css";
import "../styles/tokens.css";
import "../styles/base.css";
import "../styles/parts.css";
import "../styles/topbar.css";
import "./editor.css";
import { effect } from "@preact/signals";
import { render } from "preact";
import { onLoggedOut, toLogin } from "../api/session";
import { t, tables } from "../text/editor";
import { beginToSpeak } from "../text/speech";
import { followTheme } from "../theme/theme";
import { Editor } from "./Editor";
import { open } from "./state";

await beginToSpeak(tables);
effect(() => {
  document.title = `Dray – ${t("title")}`;
});
onLoggedOut(toLogin);
followTheme();

const asked = location.hash.slice(1);
// One that is gone is not among those that are listed then.
if (asked !== "") await open(asked).catch(() => undefined);

const root = document.getElementById("app");
if (root) render(<Editor />, root);
