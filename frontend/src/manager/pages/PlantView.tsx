import { computed } from "@preact/signals";
import { PlantMap } from "../../plant/PlantMap";
import { selection } from "../../selection/selection";
import { world } from "../../stream/stream";
import { t } from "../../text/manager";
import { AlertsCard } from "../alerts/AlertsCard";
import { ChosenAtv } from "../cards/atv/AtvCard";
import { DrawStrip } from "../cards/closures/DrawStrip";
import { AuctionCard } from "../cards/auction/AuctionCard";
import { FactoryCard } from "../cards/factory/FactoryCard";
import { ChosenPlace } from "../cards/machine/ChosenPlace";
import { NewsStrips } from "../cards/news/NewsStrips";
import { ScenarioCard } from "../cards/scenario/ScenarioCard";
import { OrdersCard } from "../orders/OrdersCard";
import { PublishCard } from "../cards/publish/PublishCard";
import { Later } from "../../parts/Later";
import { plant, plantFailed } from "../state";
import { follow, following } from "../story/address";
import { Legend } from "../story/Legend";
import { StoryBar } from "../story/StoryBar";
import { TourPlace } from "../story/TourPlace";

/** Whether something keeps vehicles from a part of the floor: most plants have nothing of it at most times. */
const isFloorKept = computed(() => (world.value?.closures.size ?? 0) + (world.value?.obstacles.size ?? 0) > 0);
const followed = computed(() => (following.value ? selection.value.atv : null));

/** The paper's Figure 4: the factory in the middle, what is chosen around it. */
export function PlantView() {
  return (
    <main class="plant-view" id="content" tabIndex={-1}>
      <h1 class="unseen">{t("nav.plant")}</h1>
      <div class="column left">
        {/* What comes is at the end, and an alert in sight above the form, beside what scrolls: no button changes its place, and none is covered. */}
        <div class="giving">
          <FactoryCard />
          <ScenarioCard />
          <OrdersCard />
          {isFloorKept.value && <Later load={async () => (await import("../cards/closures/FloorCards")).load()} />}
        </div>
        <AlertsCard />
        <PublishCard />
      </div>
      <div class="column middle">
        {plant.value ? (
          <PlantMap
            plant={plant.value}
            over={<><NewsStrips /><DrawStrip /><TourPlace /></>}
            aside={<Legend />}
            followed={followed}
            onMoved={() => { if (following.peek()) follow(false); }}
          />
        ) : (
          <Waiting />
        )}
        <StoryBar />
        <AuctionCard />
      </div>
      <div class="column right">
        <ChosenPlace />
        <ChosenAtv />
      </div>
    </main>
  );
}

function Waiting() {
  const reason = plantFailed.value;
  return (
    <section class="map card map-waiting" role="status">
      {reason === null ? t("map.loading") : t("map.failed", { reason })}
    </section>
  );
}
