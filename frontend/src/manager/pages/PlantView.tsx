import { PlantMap } from "../../plant/PlantMap";
import { t } from "../../text/manager";
import { AlertsCard } from "../alerts/AlertsCard";
import { ChosenAtv } from "../cards/atv/AtvCard";
import { ClosuresCard } from "../cards/closures/ClosuresCard";
import { ObstaclesCard } from "../cards/obstacles/ObstaclesCard";
import { AuctionCard } from "../cards/auction/AuctionCard";
import { FactoryCard } from "../cards/factory/FactoryCard";
import { ChosenPlace } from "../cards/machine/ChosenPlace";
import { NewsStrips } from "../cards/news/NewsStrips";
import { ScenarioCard } from "../cards/scenario/ScenarioCard";
import { OrdersCard } from "../orders/OrdersCard";
import { PublishCard } from "../cards/publish/PublishCard";
import { plant, plantFailed } from "../state";

/** The paper's Figure 4: the factory in the middle, what is chosen around it. */
export function PlantView() {
  return (
    <main class="plant-view" id="content" tabIndex={-1}>
      <h1 class="unseen">{t("nav.plant")}</h1>
      <div class="column left">
        <FactoryCard />
        <ScenarioCard />
        <AlertsCard />
        <ClosuresCard />
        <ObstaclesCard />
        <OrdersCard />
        <PublishCard />
      </div>
      <div class="column middle">
        {plant.value ? <PlantMap plant={plant.value} over={<NewsStrips />} /> : <Waiting />}
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
