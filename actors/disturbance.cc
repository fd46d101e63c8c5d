#include "actors/disturbance.h"

#include <algorithm>
#include <cmath>

namespace cairn::actors {

HeldDisturbance::HeldDisturbance(const EnvironmentConfig& config, const VehicleConfig& vehicle)
    : num_commands_(vehicle.action_size()),
      hold_steps_(std::max<int64_t>(1, std::llround(config.disturbance_hold * config.physics_rate_hz))),
      slip_(config.slip),
      steers_(vehicle.kind == VehicleConfig::Kind::kAckermann),
      random_(0, RandomPurpose::kDisturbance),
      slip_random_(0, RandomPurpose::kSlip) {
  effects_.fill({true, config.speed_disturbance});
  double turn = config.yaw_rate_disturbance;
  // tan(steering) = yaw rate · wheel base / speed
  if (vehicle.kind == VehicleConfig::Kind::kAckermann) turn = std::atan(turn * vehicle.wheel_base / vehicle.max_speed);
  if (vehicle.turns()) effects_[static_cast<size_t>(num_commands_ - 1)] = {false, turn};
}

void HeldDisturbance::Reset(const RandomStream& random, const RandomStream& slip) {
  random_ = random;
  slip_random_ = slip;
  noise_.fill(0);
  kept_.fill(1);
}

bool HeldDisturbance::Advance(int64_t step) {
  if (step % hold_steps_ != 0) return false;
  const auto last = effects_.begin() + num_commands_;
  if (slip_ == 0 && std::all_of(effects_.begin(), last, [](const Effect& effect) { return effect.gain == 0; })) {
    return false;
  }
  for (int i = 0; slip_ > 0 && i < num_commands_ - (steers_ ? 1 : 0); ++i) {
    kept_[i] = 1 - slip_ * slip_random_.Uniform();
  }
  for (int i = 0; i < num_commands_; ++i) noise_[i] = effects_[i].gain * random_.Normal();
  return true;
}

VehicleCommand HeldDisturbance::Apply(const VehicleCommand& command) const {
  VehicleCommand disturbed = command;
  for (int i = 0; i < num_commands_; ++i) {
    disturbed[i] = effects_[i].relative ? command[i] * (1 + noise_[i]) : command[i] + noise_[i];
    if (slip_ > 0) disturbed[i] *= kept_[i];
  }
  return disturbed;
}

void HeldDisturbance::Write(BlobWriter& blob) const {
  blob.Put(random_.position());
  blob.Put(noise_);
  blob.Put(slip_random_.position());
  blob.Put(kept_);
}

void HeldDisturbance::Read(BlobReader& blob) {
  uint64_t position = 0;
  blob.Get(position);
  blob.Get(noise_);
  random_.SetPosition(position);
  blob.Get(position);
  blob.Get(kept_);
  slip_random_.SetPosition(position);
}

}  // namespace cairn::actors
