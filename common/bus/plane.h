#pragma once

namespace cairn {

/// What to do where a multicast group cannot be joined.
constexpr const char* kMulticastCure =
    "check the multicast route (`ip route get 239.255.76.67`); on one host: "
    "`sudo ip route add 224.0.0.0/4 dev lo`";

/// One UDP port each, counted up from the base port: every LCM process on a port pays for each message on it.
enum class Plane { kExperience = 0, kControl = 1, kTables = 2, kTelemetry = 3 };
constexpr int kNumPlanes = 4;
/// The port after the planes' is held by the launcher's guard socket, so that two runs never share a block.
constexpr int kPortBlock = 5;
/// "experience", "control", "tables", "telemetry".
const char* PlaneName(Plane plane);

}  // namespace cairn
