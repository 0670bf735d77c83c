// Virtual vehicles of vda-5050-lib on a broker, until stdin ends.
// Argument: {broker, mapId, speed, vehicles: [{serial, node, x, y}]} as JSON; `speed` is how fast their time runs.
"use strict";
const { AgvController, VirtualAgvAdapter } = require("vda-5050-lib");

const { broker, mapId, speed, vehicles } = JSON.parse(process.argv[2]);
const MANUFACTURER = "Independent";
const TICKS_HZ = 20;

async function main() {
    const controllers = vehicles.map(({ serial, node, x, y }) => new AgvController(
        { manufacturer: MANUFACTURER, serialNumber: serial },
        { interfaceName: "uagv", vdaVersion: "2.0.0", transport: { brokerUrl: broker } },
        { agvAdapterType: VirtualAgvAdapter, publishStateInterval: 30000 / speed, publishVisualizationInterval: 0 },
        {
            initialPosition: { mapId, x, y, theta: 0, lastNodeId: node },
            vehicleSpeed: 1.5,
            tickRate: TICKS_HZ,
            timeLapse: speed,
        },
    ));
    await Promise.all(controllers.map(controller => controller.start()));
    console.log("started");
    process.stdin.resume();
    process.stdin.on("end", () => process.exit(0));
}

main().catch(error => { console.error(error); process.exit(1); });
