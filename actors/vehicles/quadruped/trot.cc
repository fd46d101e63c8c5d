#include "actors/vehicles/quadruped/trot.h"

#include <algorithm>
#include <cmath>

namespace cairn::actors {
namespace {

// Cubic from `a` to `b` over s in [0, 1] with the same slope `m` at both ends.
double Hermite(double a, double b, double m, double s) {
  return a + (b - a) * s * s * (3 - 2 * s) + m * s * (1 - s) * (1 - 2 * s);
}

}  // namespace

void Trot::Reset() { state_ = State{}; }

// True when the pairs change. At rest the clock stops there: all feet are down.
bool Trot::AdvancePhase(double dt, const Velocity& command) {
  const double reach = std::max(std::abs(params_.hip_x[0]), std::abs(params_.hip_y[0]));
  const double speed = std::max({std::abs(command.x), std::abs(command.y), reach * std::abs(command.yaw_rate)});
  const bool rest = speed < params_.rest_speed;
  double& phase = state_.phase;
  const double half = phase < 0.5 ? 0 : 0.5;
  if (rest && phase == half) return false;
  phase += dt / params_.period;
  if (phase < half + 0.5) return false;
  if (rest) phase = half + 0.5;
  if (phase >= 1) phase -= 1;
  return true;
}

FootPosition Trot::Swing(int leg, const Velocity& command, const Velocity& measured) {
  const double s = 2 * (state_.phase < 0.5 ? state_.phase : state_.phase - 0.5);
  const double stance = 0.5 * params_.period;
  const double share = 1 / (1 + params_.rolling);
  // Velocity of the trunk at the hip, and by how much it is too fast.
  const double vx = share * (command.x - command.yaw_rate * params_.hip_y[leg]);
  const double vy = share * (command.y + command.yaw_rate * params_.hip_x[leg]);
  const double excess_x = share * (measured.x - command.x), excess_y = share * (measured.y - command.y);
  const double gain = 0.5 * stance + params_.raibert_gain, limit = params_.max_step;
  const double land_x = std::clamp(0.5 * stance * vx + gain * excess_x, -limit, limit);
  const double land_y = std::clamp(0.5 * stance * vy + gain * excess_y, -limit, limit);
  Foot& foot = state_.feet[leg];
  foot.x = Hermite(foot.lifted_x, land_x, -vx * stance, s);
  foot.y = Hermite(foot.lifted_y, land_y, -vy * stance, s);
  const double up = 4 * s * (1 - s);
  return {foot.x, foot.y, -params_.leg_height + params_.lift * up * up};
}

// The foot stays on the floor while the trunk moves on.
FootPosition Trot::Stand(int leg, double dt, const Velocity& command) {
  Foot& foot = state_.feet[leg];
  const double x = params_.hip_x[leg] + foot.x, y = params_.hip_y[leg] + foot.y;
  const double move = dt / (1 + params_.rolling), limit = 1.5 * params_.max_step;
  foot.x = std::clamp(foot.x - move * (command.x - command.yaw_rate * y), -limit, limit);
  foot.y = std::clamp(foot.y - move * (command.y + command.yaw_rate * x), -limit, limit);
  return {foot.x, foot.y, -params_.leg_height};
}

std::array<FootPosition, Trot::kLegs> Trot::Advance(double dt, const Velocity& command, const Velocity& measured) {
  const bool change = AdvancePhase(dt, command);
  std::array<FootPosition, kLegs> wanted;
  for (int leg = 0; leg < kLegs; ++leg) {
    Foot& foot = state_.feet[leg];
    if (change && Swings(leg)) {
      foot.lifted_x = foot.x;
      foot.lifted_y = foot.y;
    }
    wanted[leg] = Swings(leg) ? Swing(leg, command, measured) : Stand(leg, dt, command);
  }
  return wanted;
}

}  // namespace cairn::actors
