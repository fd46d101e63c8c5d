#pragma once

#include <array>

#include "actors/sim/ode_world.h"
#include "actors/vehicles/vehicle.h"

namespace cairn::actors {

/// Physical constants of the wheeled car. `ScaledTo` starts from the paper's 70 × 50 mm car, whose numbers were tried
/// out one by one, and keeps its proportions: lengths scale with s = √(length/70 mm · width/50 mm), masses with s³,
/// the motors' torque with s⁴ (so that acceleration stays), the softness of contacts with 1/mass.
struct WheeledCarParams {
  double length = 0.070, width = 0.050, height = 0.020;  ///< chassis box [m]
  double chassis_mass = 0.15;                            ///< [kg]
  double chassis_height = 0.0165;                        ///< centre of the chassis above the floor [m]
  double wheel_radius = 0.0125;                          ///< sphere wheels, axle under the chassis's centre [m]
  double wheel_mass = 0.01;                              ///< each [kg]
  double track = 0.046;                                  ///< between the wheels' centres [m]
  double caster_radius = 0.006;                          ///< frictionless spheres fixed to the chassis [m]
  double caster_x = 0.025;                               ///< before and behind the centre [m]
  double caster_clearance = 0.0003;                      ///< above the floor when the chassis is level [m]
  double motor_torque = 0.012;                           ///< limit of each wheel's motor [N m]
  double friction = 1.0;                                 ///< μ between wheel and floor
  double wheel_speed_limit = 0;                          ///< of the motors [rad/s]
  OdeWorldParams world;
  FloorSurface wheel_surface;
  FloorSurface caster_surface;

  static WheeledCarParams ScaledTo(const VehicleConfig& vehicle);
};

/// Differential drive in ODE, commands (v, ω): chassis, two sphere wheels with velocity motors of limited torque, two
/// casters. Chassis and wheels are one body, how fast each wheel turns about its axle is counted beside it, and the
/// floor meets the wheels' moving surface: the car of three bodies on two hinges (HingedCar of the tests drives beside
/// it) without the hinges' twelve rows, which took more than half of the time.
class WheeledCar final : public Vehicle {
 public:
  /// `time_step` [s] is that of physics, `parameter_spread` relative, of mass and friction.
  WheeledCar(const WheeledCarParams& params, double time_step, double parameter_spread);

  void Reset(const Pose& pose, RandomStream& random) override;
  void Command(const VehicleCommand& command) override;
  void Step() override;
  Motion motion() const override;
  std::string Save() const override;
  void Load(const std::string& blob) override;

  const WheeledCarParams& params() const { return params_; }
  /// Height of the chassis's centre above the floor [m].
  double chassis_height() const;
  /// Spin of the left (0) or right (1) wheel about its axle [rad/s], positive forwards.
  double wheel_speed(int wheel) const { return episode_.wheels[wheel].speed; }

 private:
  struct Wheel {
    double target = 0;      ///< commanded [rad/s]
    double speed = 0;       ///< about the axle, beside the chassis [rad/s]
    double push = 0;        ///< torque against the chassis that turns it in this step, as expected [N m]
    double owed = 0;        ///< of the last step's: what the chassis felt more than what it turned out to be [N m]
    double side_force = 0;  ///< of the floor in the last step, to the left [N]
    int64_t free = 0;       ///< whether it turns freely in this step; eight bytes wide: no padding in the blob
  };
  void ApplyParameters();
  FloorSurface Drive(Wheel& wheel, bool touches, double ground_speed, double pitch_rate) const;
  void Turn(Wheel& wheel, double traction, double pitched) const;

  WheeledCarParams params_;
  double time_step_;
  double spread_;
  double wheel_inertia_;  // of each wheel about its axle [kg m²]
  double origin_ = 0;     // height of the body's centre of mass when it stands [m]
  double mass_ = 0;       // of all [kg]
  OdeWorld world_;
  dBodyID body_;
  // What one episode has of its own; all of it is in Save.
  struct Episode {
    double mass_factor = 1;
    double friction_factor = 1;
    std::array<Wheel, 2> wheels;
  } episode_;
};

}  // namespace cairn::actors
