import { useSignal, useSignalEffect } from "@preact/signals";
import type { FunctionComponent } from "preact";
import { t } from "../../../text/manager";

/** The figures over time. Charts are loaded when somebody looks at them: the plant comes first. */
export function KpiView() {
  const Charts = useSignal<FunctionComponent | null>(null);
  const failed = useSignal(false);
  useSignalEffect(() => {
    import("./charts/KpiCharts").then(
      (loaded) => {
        Charts.value = loaded.KpiCharts;
      },
      () => {
        failed.value = true;
      },
    );
  });
  if (Charts.value) return <Charts.value />;
  return (
    <main class="table-view" id="content" tabIndex={-1} aria-busy={!failed.value}>
      <section class="card">
        <header class="card-head">
          <h1>{t("kpis.title")}</h1>
        </header>
        <p class="empty" role="status">
          {t(failed.value ? "kpis.notLoaded" : "kpis.loading")}
        </p>
      </section>
    </main>
  );
}
