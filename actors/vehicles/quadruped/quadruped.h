#pragma once

#include <array>

#include "actors/sim/ode_world.h"
#include "actors/vehicles/quadruped/trot.h"
#include "actors/vehicles/vehicle.h"

namespace cairn::actors {

/// Physical constants of the quadruped. `ScaledTo` starts from one with a trunk of 100 mm x 50 mm whose numbers were
/// tried out one by one, and keeps its proportions: with s = √(length ratio · width ratio), lengths scale with s, times
/// and speeds with √s (gravity stays), masses with s³, torques with s⁴.
struct QuadrupedParams {
  double length = 0.10, width = 0.05, height = 0.025;  ///< of the trunk [m]
  double trunk_mass = 0.29;                            ///< with the abduction motors in it [kg]
  double thigh_mass = 0.012, shank_mass = 0.008;       ///< of each leg [kg]
  double hip_x = 0.04, hip_y = 0.025;                  ///< hips at (±hip_x, ±hip_y) in the trunk's middle plane [m]
  LegLengths leg{0.04, 0.04};
  double link_width = 0.006;     ///< of thigh and shank, for their inertia [m]
  double foot_radius = 0.006;    ///< [m]
  double stance_height = 0.062;  ///< of the hips over the floor [m]
  double joint_gain = 25;        ///< joint speed over angle error, besides the wanted speed [1/s]
  double joint_speed = 40;       ///< limit [rad/s]
  double joint_torque = 0.35;    ///< limit [N m]
  double max_tilt = 0.8;         ///< of the trunk's axis; beyond it has fallen [rad]
  double speed_limit = 0.45;     ///< of commands [m/s]
  double yaw_rate_limit = 3;     ///< of commands [rad/s]
  double acceleration = 2;       ///< the gait follows a command no faster than this [m/s²]
  double yaw_acceleration = 40;  ///< [rad/s²]
  TrotParams trot;               ///< leg_height and hips are derived
  /// Of the feet, which give like rubber: 0.6 mm under the weight. On hard ones (soft_cfm 1e-5) landing feet kicked the
  /// trunk about, and it fell at half the speed.
  FloorSurface surface{1.0, 0.4, 0.03};
  OdeWorldParams world;

  static QuadrupedParams ScaledTo(const VehicleConfig& vehicle);
};

/// A quadruped in ODE: a trunk and four legs of thigh and shank, twelve joints (abduction and hip, one universal joint,
/// and knee) with velocity motors of limited torque, which follow a trot. Commands (v [m/s], yaw rate [rad/s]).
class Quadruped final : public Vehicle {
 public:
  static constexpr int kLegs = Trot::kLegs;

  /// `time_step` [s] is that of physics, `parameter_spread` relative, of the trunk's mass and of friction.
  Quadruped(const QuadrupedParams& params, double time_step, double parameter_spread);

  void Reset(const Pose& pose, RandomStream& random) override;
  void Command(const VehicleCommand& command) override;
  void Step() override;
  Motion motion() const override;
  bool fallen() const override;
  std::string Save() const override;
  void Load(const std::string& blob) override;

  const QuadrupedParams& params() const { return params_; }
  const Trot& trot() const { return trot_; }
  /// Height of the trunk's centre [m].
  double height() const { return dBodyGetPosition(trunk_)[2]; }
  /// Cosine of the angle between its axis and the vertical.
  double uprightness() const { return dBodyGetRotation(trunk_)[10]; }
  LegAngles angles(int leg) const;
  /// Force of the floor on each foot in the last step [N], W; kept only while asked for.
  void MeasureContacts(std::array<dJointFeedback, kLegs>* feedback) { feedback_ = feedback; }

 private:
  struct Leg {
    dBodyID thigh, shank;
    dJointID hip, knee;  // hip: universal, axis 1 abduction
  };
  void AddLeg(int leg);
  void PlaceLeg(int leg, const Pose& pose, const LegAngles& angles);
  void ApplyParameters();
  void Approach();
  Trot::Velocity Measure() const;
  void DriveJoints();
  void AddContacts();

  QuadrupedParams params_;
  double time_step_;
  double spread_;
  OdeWorld world_;
  dBodyID trunk_;
  std::array<Leg, kLegs> legs_;
  Trot trot_;
  std::array<dJointFeedback, kLegs>* feedback_ = nullptr;
  // What one episode has of its own; with the trot's state all of it is in Save.
  struct Episode {
    double mass_factor = 1;
    double friction_factor = 1;
    VehicleCommand command{};
    Trot::Velocity target;                  ///< on its way to the command
    std::array<LegAngles, kLegs> wanted{};  ///< at the end of the last step
  } episode_;
};

}  // namespace cairn::actors
