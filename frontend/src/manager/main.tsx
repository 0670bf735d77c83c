/** The management panel's page. */
import "@fontsource-variable/inter/wght.css";
import "../styles/tokens.css";
import "../styles/base.css";
import "../styles/parts.css";
import "../styles/topbar.css";
import "../styles/plant.css";
import "../styles/cards.css";
import "../styles/alerts.css";
import { render } from "preact";
import { bring } from "../api/bring";
import { onLoggedOut, toLogin } from "../api/session";
import { followChanges } from "../plant/load";
import { start, world } from "../stream/stream";
import { tables } from "../text/manager";
import { beginToSpeak } from "../text/speech";
import { followTheme } from "../theme/theme";
import { followSelection } from "./story/address";
import { App } from "./App";
import { chooseAtFirst } from "./first-look";
import { plantAsked } from "./plant-asked";
import { learnWho } from "./shell/session";
import { plant } from "./state";
import { followAddress } from "./views";

await beginToSpeak(tables);
onLoggedOut(toLogin);
void learnWho();
followTheme();
followAddress();
chooseAtFirst();
followSelection();
start();
bring(() => import("./alerts/telling/telling"), ({ beginToTell, followTitle }) => { followTitle(); beginToTell(); });
void plantAsked.now();
followChanges(world, plant, plantAsked);

const root = document.getElementById("app");
if (root) render(<App />, root);
