#pragma once

#include <array>

#include "actors/vehicles/quadruped/leg.h"

namespace cairn::actors {

/// Constants of the gait.
struct TrotParams {
  double period = 0.15;        ///< of one cycle; every foot stands for half of it [s]
  double lift = 0.015;         ///< height of a swinging foot over the floor [m]
  double leg_height = 0.056;   ///< of the hips over the centres of standing feet [m]
  double raibert_gain = 0.03;  ///< beyond the neutral point of the measured velocity, see Trot [s]
  double max_step = 0.035;     ///< a foot lands no further than this from where it stands at rest, along each axis [m]
  double rest_speed = 1e-3;    ///< commands that move no foot faster than this are rest [m/s]
  double rolling = 0;          ///< way that a standing foot rolls on, over the way of its centre under the trunk
  std::array<double, 4> hip_x{}, hip_y{};  ///< in the trunk's frame [m]; left and right in front, left and right behind
};

/// The trot: diagonal pairs of feet swing in turn. Standing feet move against the commanded velocity of the trunk,
/// swinging ones to where the next stance begins: measured velocity · half a stance + raibert_gain · (measured −
/// commanded) ahead of the hip (Raibert 1986, Legged Robots That Balance, chapter 2), which brakes a trunk that is too
/// fast or leans. Told to rest, it stands on all feet from the next change of pairs on.
class Trot {
 public:
  /// Velocity of the trunk in its own level frame [m/s, rad/s].
  struct Velocity {
    double x = 0, y = 0, yaw_rate = 0;
  };
  static constexpr int kLegs = 4;

  explicit Trot(const TrotParams& params) : params_(params) { Reset(); }

  /// All feet under their hips, at a change of pairs.
  void Reset();

  /// Advances by dt [s] and gives the wanted foot of each leg.
  std::array<FootPosition, kLegs> Advance(double dt, const Velocity& command, const Velocity& measured);

  /// Whether a leg swings now: the pair left front, right behind in the second half of the cycle.
  bool Swings(int leg) const { return (phase() >= 0.5) == (leg == 0 || leg == 3); }

  /// In [0, 1); the pairs change at 0 and ½.
  double phase() const { return state_.phase; }

  const TrotParams& params() const { return params_; }

  // What one episode has of its own, all doubles, for Vehicle::Save.
  struct Foot {
    double x = 0, y = 0;                ///< relative to the hip [m]
    double lifted_x = 0, lifted_y = 0;  ///< where it left the floor
  };
  struct State {
    double phase = 0;
    std::array<Foot, kLegs> feet{};
  };
  const State& state() const { return state_; }
  void set_state(const State& state) { state_ = state; }

 private:
  bool AdvancePhase(double dt, const Velocity& command);
  FootPosition Swing(int leg, const Velocity& command, const Velocity& measured);
  FootPosition Stand(int leg, double dt, const Velocity& command);

  TrotParams params_;
  State state_;
};

}  // namespace cairn::actors
