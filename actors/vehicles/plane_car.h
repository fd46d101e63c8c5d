#pragma once

#include "actors/sim/ode_world.h"
#include "actors/vehicles/vehicle.h"

namespace cairn::actors {

/// The fast car: one ODE body held in the plane (Plane2D joint) whose velocity motors follow the command with a
/// first-order lag: speed' = (command − speed) / lag, yaw rate alike; no side slip.
class PlaneCar final : public Vehicle {
 public:
  /// `time_step` [s] is that of physics, `parameter_spread` relative, of mass and friction.
  PlaneCar(const VehicleConfig& vehicle, double time_step, double parameter_spread);

  void Reset(double x, double y, double yaw, RandomStream& random) override;
  void Command(double speed, double yaw_rate) override;
  void Step() override;
  GroundState state() const override;
  std::string Save() const override;
  void Load(const std::string& blob) override;

 private:
  void SetLag(double lag);

  double time_step_;
  double spread_;
  double lag_;
  double speed_limit_;
  double yaw_rate_limit_;
  OdeWorld world_;
  dBodyID body_;
  dJointID plane_;
  // What one episode has of its own; all of it is in Save.
  struct Episode {
    double blend = 1;  ///< share of the gap to the command closed in a physics step
    double target_speed = 0, target_yaw_rate = 0;
    double speed = 0, yaw_rate = 0;
  } episode_;
};

}  // namespace cairn::actors
