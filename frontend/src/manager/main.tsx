/** The management panel's page. */
import "@fontsource-variable/inter/wght.css";
import "../styles/tokens.css";
import "../styles/base.css";
import "../styles/parts.css";
import "../styles/topbar.css";
import "../styles/plant.css";
import "../styles/cards.css";
import "../styles/alerts.css";
import { effect } from "@preact/signals";
import { render } from "preact";
import { onLoggedOut, toLogin } from "../api/session";
import { followJoining, loadPlant } from "../plant/load";
import { start, world } from "../stream/stream";
import { t, tables } from "../text/manager";
import { beginToSpeak } from "../text/speech";
import { followTheme } from "../theme/theme";
import { App } from "./App";
import { chooseAtFirst } from "./first-look";
import { problemText } from "./problem-text";
import { learnWho } from "./shell/session";
import { plant, plantFailed } from "./state";
import { followAddress } from "./views";

await beginToSpeak(tables);
effect(() => {
  document.title = t("app.title");
});
onLoggedOut(toLogin);
void learnWho();
followTheme();
followAddress();
chooseAtFirst();
start();
const askForPlant = () => void loadPlant(plant, plantFailed, problemText);
askForPlant();
followJoining(plant, world, askForPlant);

const root = document.getElementById("app");
if (root) render(<App />, root);
