#include "actors/command_delay.h"

#include <algorithm>
#include <cmath>

#include "actors/command.h"

namespace cairn::actors {

CommandDelay::CommandDelay(const Experiment& experiment, int control_steps)
    : config_(experiment.environment), control_steps_(control_steps), rest_(RestCommand(experiment.vehicle)) {
  const double longest = (config_.action_delay + config_.action_delay_spread) * config_.physics_rate_hz;
  const auto more = static_cast<size_t>(std::ceil(longest / control_steps)) + 1;
  ring_.resize(static_cast<size_t>(config_.action_delay_steps) + more);
}

void CommandDelay::Reset(RandomStream& parameters) {
  double seconds = config_.action_delay;
  if (config_.action_delay_spread > 0) {
    seconds += parameters.Uniform(-config_.action_delay_spread, config_.action_delay_spread);
  }
  delay_ = config_.action_delay_steps * control_steps_ + std::llround(std::max(0.0, seconds) * config_.physics_rate_hz);
  std::fill(ring_.begin(), ring_.end(), rest_);
}

void CommandDelay::Push(int step, const VehicleCommand& command) { ring_[Slot(step)] = command; }

int CommandDelay::InForce(int step, int i) const {
  const int64_t time = step * control_steps_ + i - delay_;
  return time < 0 ? -1 : static_cast<int>(time / control_steps_);
}

const VehicleCommand& CommandDelay::command(int number) const { return number < 0 ? rest_ : ring_[Slot(number)]; }

void CommandDelay::Write(BlobWriter& blob) const {
  blob.Put(delay_);
  for (const VehicleCommand& command : ring_) blob.Put(command);
}

void CommandDelay::Read(BlobReader& blob) {
  blob.Get(delay_);
  for (VehicleCommand& command : ring_) blob.Get(command);
}

}  // namespace cairn::actors
