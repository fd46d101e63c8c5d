#include "actors/vehicles/vehicle.h"

#include "actors/vehicles/plane_base/plane_base.h"
#include "actors/vehicles/quadrotor/quadrotor.h"
#include "actors/vehicles/quadruped/quadruped.h"
#include "actors/vehicles/wheeled_car/wheeled_car.h"
#include "common/core/check.h"

namespace cairn::actors {

std::unique_ptr<Vehicle> MakeVehicle(const VehicleConfig& vehicle, const EnvironmentConfig& environment) {
  const double time_step = 1.0 / environment.physics_rate_hz;
  const double spread = environment.parameter_spread;
  switch (vehicle.kind) {
    case VehicleConfig::Kind::kWheeledCar:
      return std::make_unique<WheeledCar>(WheeledCarParams::ScaledTo(vehicle), time_step, spread);
    case VehicleConfig::Kind::kPlaneCar:
    case VehicleConfig::Kind::kHolonomic:
    case VehicleConfig::Kind::kAckermann:
      return std::make_unique<PlaneBase>(vehicle, time_step, spread);
    case VehicleConfig::Kind::kQuadrotor:
      return std::make_unique<Quadrotor>(QuadrotorParams::ScaledTo(vehicle), time_step, spread);
    case VehicleConfig::Kind::kQuadruped:
      return std::make_unique<Quadruped>(QuadrupedParams::ScaledTo(vehicle), time_step, spread);
  }
  ThrowUsageError("vehicle.kind = {}: no such vehicle", static_cast<int>(vehicle.kind));
}

}  // namespace cairn::actors
