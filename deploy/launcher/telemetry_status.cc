#include "deploy/launcher/telemetry_status.h"

#include <fmt/core.h>

#include <memory>

namespace cairn::deploy {
namespace {

constexpr auto kOutageShows = std::chrono::milliseconds(500);

RunStatus ToStatus(const LearnerTelemetry& telemetry) {
  RunStatus status;
  status.env_steps = telemetry.env_steps;
  status.total_env_steps = telemetry.total_env_steps;
  status.env_steps_per_s = telemetry.env_steps_per_s;
  status.updates_per_s = telemetry.updates_per_s;
  if (telemetry.env_steps > 0) status.success_rate = telemetry.success_rate;  // 0 before the first episode
  status.consumption_env_steps = telemetry.consumption_env_steps;
  status.warning = telemetry.warning;
  status.phase = telemetry.phase;
  return status;
}

// The bus and what it heard last; handlers run inside Poll, on the caller's thread.
struct Listener {
  explicit Listener(const BusConfig& config) : bus(config) {
    bus.Subscribe<LearnerTelemetry>(
        Plane::kTelemetry, kLearnerChannel,
        [this](const LearnerTelemetry& telemetry, const FrameInfo&) { newest = ToStatus(telemetry); });
  }
  Bus bus;
  std::optional<RunStatus> newest;
};

}  // namespace

StatusSource MakeTelemetryStatus(const BusConfig& bus) {
  auto listener = std::make_shared<Listener>(bus);
  return [listener] {
    listener->bus.Poll(Duration::zero());
    std::optional<RunStatus> status = listener->newest;
    const std::optional<Outage> outage = listener->bus.outage();
    if (!outage || Clock::now() - outage->since < kOutageShows) return status;
    if (!status) status = RunStatus{.phase = "starting"};
    status->warning = fmt::format("no broker at tcpq://{} for {:.0f} s ({}): waiting", outage->broker,
                                  SecondsSince(outage->since), outage->reason);
    return status;
  };
}

}  // namespace cairn::deploy
