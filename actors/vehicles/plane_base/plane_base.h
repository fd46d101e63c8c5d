#pragma once

#include "actors/sim/ode_world.h"
#include "actors/vehicles/vehicle.h"

namespace cairn::actors {

/// The fast ground vehicles: one ODE body held in the plane (Plane2D joint) whose velocity motors follow the commands
/// with a first-order lag: c' = (command − c) / lag, speeds no faster than max_acceleration; no slip of tyres.
///   PLANE_CAR  c = (v, ω): moves along its x axis.
///   HOLONOMIC  c = (vx, vy, ω) in its own frame.
///   ACKERMANN  c = (v, δ): v of the middle of the rear axle, δ the steering of a single-track model, ω = v tan δ / L;
///   the
///              centre lies half a wheel base L ahead of the axle, so it also moves sideways, by ω L / 2.
class PlaneBase final : public Vehicle {
 public:
  /// `time_step` [s] is that of physics, `parameter_spread` relative, of mass and friction.
  PlaneBase(const VehicleConfig& vehicle, double time_step, double parameter_spread);

  void Reset(const Pose& pose, RandomStream& random) override;
  void Command(const VehicleCommand& command) override;
  void Step() override;
  Motion motion() const override;
  std::string Save() const override;
  void Load(const std::string& blob) override;

 private:
  struct Velocity {
    double x, y, yaw_rate;  // in the body's frame
  };
  void SetLag(double lag);
  Velocity BodyVelocity() const;

  VehicleConfig config_;
  double time_step_;
  double spread_;
  VehicleCommand limits_;     // of what is followed, per command
  VehicleCommand max_steps_;  // largest change in a physics step, per command
  OdeWorld world_;
  dBodyID body_;
  dJointID plane_;
  // What one episode has of its own; all of it is in Save.
  struct Episode {
    double blend = 1;          ///< share of the gap to the command closed in a physics step
    VehicleCommand target{};   ///< commanded
    VehicleCommand current{};  ///< what the motors do
  } episode_;
};

}  // namespace cairn::actors
