import { t } from "../text/manager";
import { AlertsView } from "./alerts/AlertsView";
import { AuditView } from "./pages/audit/AuditView";
import { FleetView } from "./pages/FleetView";
import { KpiView } from "./pages/kpis/KpiView";
import { OrdersView } from "./orders/OrdersView";
import { PlantView } from "./pages/PlantView";
import { PromisesView } from "./pages/promises/PromisesView";
import { TasksView } from "./pages/tasks/TasksView";
import { NewsBanner } from "./shell/NewsBanner";
import { TopBar } from "./shell/TopBar";
import { view } from "./views";
import { WatchView } from "./pages/watch/WatchView";

const SHOWN = {
  plant: PlantView,
  alerts: AlertsView,
  orders: OrdersView,
  fleet: FleetView,
  tasks: TasksView,
  watch: WatchView,
  promises: PromisesView,
  kpis: KpiView,
  audit: AuditView,
};

/** The address names the view; what is skipped to must not change it. */
function skip(event: Event): void {
  event.preventDefault();
  document.getElementById("content")?.focus();
}

export function App() {
  const View = SHOWN[view.value];
  return (
    <div class="app">
      <a class="skip" href="#content" onClick={skip}>
        {t("skip.toContent")}
      </a>
      <TopBar />
      <NewsBanner />
      <View />
    </div>
  );
}
