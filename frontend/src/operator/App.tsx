import { t } from "../text/operator";
import { Said } from "./commands/Said";
import { Floor } from "./Floor";
import { Banner } from "./top/Banner";
import { TopBar } from "./top/TopBar";

export function App() {
  return (
    <div class="app operator">
      <a class="skip" href="#vehicles">
        {t("skip.toVehicles")}
      </a>
      <a class="skip" href="#stops">
        {t("skip.toStop")}
      </a>
      <TopBar />
      <Banner />
      <Floor />
      <Said />
    </div>
  );
}
