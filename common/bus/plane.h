#pragma once

namespace cairn {

/// One UDP port each, counted up from the base port: every LCM process on a port pays for each message on it.
enum class Plane { kExperience = 0, kControl = 1, kTables = 2, kTelemetry = 3 };
constexpr int kNumPlanes = 4;
/// The port after the planes' is held by the launcher's guard socket, so that two runs never share a block.
constexpr int kPortBlock = 5;
/// "experience", "control", "tables", "telemetry".
const char* PlaneName(Plane plane);

}  // namespace cairn
