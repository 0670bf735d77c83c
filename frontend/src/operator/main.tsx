/** The operator panel's page. */
import "@fontsource-variable/inter/wght.css";
import "../styles/tokens.css";
import "../styles/base.css";
import "../styles/parts.css";
import "../styles/plant.css";
import "./operator.css";
import { effect, signal } from "@preact/signals";
import { render } from "preact";
import { followChanges, plantLoading } from "../plant/load";
import { start, world } from "../stream/stream";
import { t, tables } from "../text/operator";
import { beginToSpeak } from "../text/speech";
import { followTheme } from "../theme/theme";
import { App } from "./App";
import { askingCaller, beginDuty } from "./duty/duty";
import { problemText } from "./problem-text";
import { beginSession } from "./session/session";
import { installShell } from "./shell/install";
import { keepAwake } from "./shell/wake-lock";
import { plant, plantFailed } from "./state";

await beginToSpeak(tables);
effect(() => {
  document.title = askingCaller.value === "" ? t("app.title") : t("call.tab", { caller: askingCaller.value, title: t("app.title") });
});
followTheme();
keepAwake();
installShell();
beginSession();
beginDuty();
start();
const plantAsked = plantLoading(plant, plantFailed, signal(null), problemText);
void plantAsked.now();
followChanges(world, plant, plantAsked);

const root = document.getElementById("app");
if (root) render(<App />, root);
