#pragma once

#include <array>

#include "actors/sim/ode_world.h"
#include "actors/vehicles/wheeled_car/wheeled_car.h"

namespace cairn::actors {

/// The wheeled car as three bodies and two hinges with motors: what WheeledCar must drive like.
class HingedCar final : public Vehicle {
 public:
  /// `time_step` [s] is that of physics, `parameter_spread` relative, of mass and friction.
  HingedCar(const WheeledCarParams& params, double time_step, double parameter_spread);

  void Reset(const Pose& pose, RandomStream& random) override;
  void Command(const VehicleCommand& command) override;
  void Step() override;
  Motion motion() const override;
  std::string Save() const override;
  void Load(const std::string& blob) override;

  const WheeledCarParams& params() const { return params_; }
  /// Height of the chassis's centre above the floor [m].
  double chassis_height() const { return dBodyGetPosition(chassis_)[2]; }
  /// Spin of the left (0) or right (1) wheel about its axle [rad/s], positive forwards.
  double wheel_speed(int wheel) const { return dJointGetHingeAngleRate(hinges_[wheel]); }

 private:
  void AddWheel(int wheel, double y);
  void ApplyParameters();
  void SetMotors();
  void AddContacts();

  WheeledCarParams params_;
  double time_step_;
  double spread_;
  OdeWorld world_;
  dBodyID chassis_;
  std::array<dBodyID, 2> wheels_;
  std::array<dJointID, 2> hinges_;
  // What one episode has of its own; all of it is in Save.
  struct Episode {
    double mass_factor = 1;
    double friction_factor = 1;
    std::array<double, 2> motor_speed{};  ///< commanded [rad/s]
  } episode_;
};

}  // namespace cairn::actors
