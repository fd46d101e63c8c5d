#pragma once

#include "deploy/launcher/train.h"

namespace cairn::deploy {

/// Listens to the learner's telemetry.
StatusSource MakeTelemetryStatus(const BusConfig& bus);

}  // namespace cairn::deploy
