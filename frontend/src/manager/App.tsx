import type { FunctionComponent } from "preact";
import { t } from "../text/manager";
import { PlantView } from "./pages/PlantView";
import { Loaded } from "./parts/Loaded";
import { NewsBanner } from "./shell/NewsBanner";
import { TopBar } from "./shell/TopBar";
import { step } from "./story/tour";
import { isTransport, shownOrder, shownTransport, view } from "./views";

/** A view whose script comes when somebody looks at it; until then its name in the menu stands there. */
const later =
  (load: () => Promise<FunctionComponent>, title?: "alerts.title" | "nav.kpis" | "nav.orders" | "nav.people" | "nav.tasks"): FunctionComponent =>
  () => <Loaded title={t(title ?? (`nav.${view.value}` as "nav.kpis"))} load={load} />;

const SHOWN = {
  plant: PlantView,
  alerts: later(async () => (await import("./alerts/AlertsView")).load(), "alerts.title"),
  orders: later(async () => (await import("./orders/list/OrdersList")).load()),
  products: later(async () => (await import("./pages/products/define/Products")).load()),
  fleet: later(async () => (await import("./pages/FleetView")).FleetView),
  tasks: later(async () => (await import("./pages/tasks/TasksList")).load()),
  watch: later(async () => (await import("./pages/watch/WatchView")).load()),
  promises: later(async () => (await import("./pages/promises/PromisesView")).load()),
  kpis: later(async () => (await import("./pages/kpis/charts/KpiCharts")).load()),
  audit: later(async () => (await import("./pages/audit/AuditList")).load()),
  replay: later(async () => (await import("./replay/page/Replay")).load()),
  recurring: later(async () => (await import("./pages/recurring/Recurring")).load(), "nav.orders"),
  transports: later(async () => (await import("./pages/transports/TransportsList")).load(), "nav.tasks"),
  people: later(async () => (await import("./pages/people/People")).load(), "nav.people"),
  shift: later(async () => (await import("./pages/shift/report/ShiftReport")).load(), "nav.kpis"),
};

const OrderPage = later(async () => (await import("./orders/page/OrderStory")).load());
const TransportPage = later(async () => (await import("./pages/transports/page/TransportStory")).load(), "nav.tasks");
const TaskPage = later(async () => (await import("./pages/transports/page/TaskStory")).load(), "nav.tasks");

/** An order and a transport have a page of their own; all others are views. */
function shown(): FunctionComponent {
  if (view.value === "orders" && shownOrder.value !== "") return OrderPage;
  if (view.value === "transports" && shownTransport.value !== "") return isTransport(shownTransport.value) ? TransportPage : TaskPage;
  return SHOWN[view.value];
}

/** The address names the view; what is skipped to must not change it. */
function skip(event: Event): void {
  event.preventDefault();
  document.getElementById("content")?.focus();
}

export function App() {
  const View = shown();
  return (
    <div class="app" data-tour={view.value === "plant" && step.value > 0 ? step.value : undefined}>
      <a class="skip" href="#content" onClick={skip}>
        {t("skip.toContent")}
      </a>
      <TopBar />
      <NewsBanner />
      <View />
    </div>
  );
}
