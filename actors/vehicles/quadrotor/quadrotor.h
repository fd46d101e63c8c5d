#pragma once

#include <array>

#include "actors/sim/ode_world.h"
#include "actors/vehicles/vehicle.h"

namespace cairn::actors {

/// Physical constants of the quadrotor. `ScaledTo` starts from a Crazyflie-like one of radius 45 mm whose numbers were
/// tried out one by one, and keeps its proportions: with s = radius / 45 mm, lengths scale with s, masses and thrusts
/// with s³, inertias with s⁵; accelerations and time constants stay.
struct QuadrotorParams {
  double radius = 0.045;                                   ///< of the sphere around it [m]
  double mass = 0.027;                                     ///< [kg]
  std::array<double, 3> inertia{1.4e-5, 1.4e-5, 2.17e-5};  ///< about its axes [kg m²]
  double arm = 0.028;                                      ///< rotors at (±arm, ±arm) [m]
  double max_thrust = 0.149;                               ///< of each rotor [N]
  double torque_per_thrust = 0.00594;                      ///< of each rotor about its axis [m]
  double motor_lag = 0.02;                                 ///< time constant of a rotor's thrust [s]
  double velocity_gain = 10;                               ///< wanted acceleration over velocity error [1/s]
  double attitude_frequency = 40;                          ///< of the closed attitude loop [rad/s]
  double attitude_damping = 0.8;                           ///< its damping ratio
  double torque_reserve = 0.25;     ///< share of a rotor's thrust kept free both ways for torques
  double max_attitude_error = 0.3;  ///< of which the torques take notice [sine]
  double max_tilt = 0.95;           ///< of the wanted thrust [rad]
  double max_climb = 6;             ///< wanted vertical acceleration, either way [m/s²]
  double speed_limit = 2.25;        ///< of commands, per axis [m/s]
  OdeWorldParams world;

  static QuadrotorParams ScaledTo(const VehicleConfig& vehicle);
};

/// A quadrotor in ODE: one free body moved by four rotor thrusts under a velocity controller (wanted acceleration →
/// wanted thrust vector → torques, geometric control after Lee, Leok and McClamroch 2010) that holds its yaw. Commands
/// (vx, vy, vz) [m/s].
class Quadrotor final : public Vehicle {
 public:
  /// `time_step` [s] is that of physics, `parameter_spread` relative, of mass and thrust.
  Quadrotor(const QuadrotorParams& params, double time_step, double parameter_spread);

  void Reset(const Pose& pose, RandomStream& random) override;
  void Command(const VehicleCommand& command) override;
  void Step() override;
  Motion motion() const override;
  std::string Save() const override;
  void Load(const std::string& blob) override;

  const QuadrotorParams& params() const { return params_; }
  /// Cosine of the angle between its axis and the vertical.
  double uprightness() const { return dBodyGetRotation(body_)[10]; }
  /// Thrusts of the rotors at (+, +), (−, +), (−, −), (+, −) in its frame [N].
  const std::array<double, 4>& thrusts() const { return episode_.thrust; }

 private:
  // Total thrust [N] and torques about the body's axes [N m].
  struct Wrench {
    double thrust, torque[3];
  };
  Wrench Control() const;
  std::array<double, 4> Mix(const Wrench& wanted) const;
  void ApplyParameters();

  QuadrotorParams params_;
  double time_step_;
  double spread_;
  double blend_;  // share of the gap to the wanted thrust closed in a physics step
  OdeWorld world_;
  dBodyID body_;
  // What one episode has of its own; all of it is in Save.
  struct Episode {
    double mass_factor = 1;
    double thrust_factor = 1;
    double yaw = 0;  ///< held
    VehicleCommand command{};
    std::array<double, 4> thrust{};  ///< of the rotors now [N]
  } episode_;
};

}  // namespace cairn::actors
