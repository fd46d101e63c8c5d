#include "actors/disturbance.h"

#include <algorithm>
#include <cmath>

namespace cairn::actors {

HeldDisturbance::HeldDisturbance(const EnvironmentConfig& config)
    : speed_gain_(config.speed_disturbance),
      yaw_rate_gain_(config.yaw_rate_disturbance),
      hold_steps_(std::max<int64_t>(1, std::llround(config.disturbance_hold * config.physics_rate_hz))),
      random_(0, RandomPurpose::kDisturbance) {}

void HeldDisturbance::Reset(const RandomStream& random) {
  random_ = random;
  speed_noise_ = yaw_rate_noise_ = 0;
}

bool HeldDisturbance::Advance(int64_t step) {
  if (step % hold_steps_ != 0 || (speed_gain_ == 0 && yaw_rate_gain_ == 0)) return false;
  speed_noise_ = speed_gain_ * random_.Normal();
  yaw_rate_noise_ = yaw_rate_gain_ * random_.Normal();
  return true;
}

DriveCommand HeldDisturbance::Apply(const DriveCommand& command) const {
  return {command.speed * (1 + speed_noise_), command.yaw_rate + yaw_rate_noise_};
}

void HeldDisturbance::Write(BlobWriter& blob) const {
  blob.Put(random_.position());
  blob.Put(speed_noise_);
  blob.Put(yaw_rate_noise_);
}

void HeldDisturbance::Read(BlobReader& blob) {
  uint64_t position = 0;
  blob.Get(position);
  blob.Get(speed_noise_);
  blob.Get(yaw_rate_noise_);
  random_.SetPosition(position);
}

}  // namespace cairn::actors
