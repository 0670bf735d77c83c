import { useSignal, useSignalEffect } from "@preact/signals";
import type { FunctionComponent } from "preact";
import { bring } from "../../api/bring";
import { t } from "../../text/manager";

interface Props {
  title: string;
  load: () => Promise<FunctionComponent>;
}

/** A view whose script is loaded when somebody looks at it: the plant comes first. */
export function Loaded({ load, title }: Props) {
  const View = useSignal<FunctionComponent | null>(null);
  const failed = useSignal(false);
  useSignalEffect(() => bring(load, (loaded) => { View.value = loaded; }, () => { failed.value = true; }));
  if (View.value) return <View.value />;
  return (
    <main class="table-view" id="content" tabIndex={-1} aria-busy={!failed.value}>
      <section class="card">
        <header class="card-head">
          <h1>{title}</h1>
        </header>
        <p class="empty" role="status">
          {t(failed.value ? "view.notLoaded" : "view.loading")}
        </p>
      </section>
    </main>
  );
}
