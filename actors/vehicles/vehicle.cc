#include "actors/vehicles/vehicle.h"

#include "actors/vehicles/plane_car.h"
#include "actors/vehicles/wheeled_car.h"
#include "common/core/check.h"

namespace cairn::actors {

std::unique_ptr<Vehicle> MakeVehicle(const VehicleConfig& vehicle, const EnvironmentConfig& environment) {
  const double time_step = 1.0 / environment.physics_rate_hz;
  switch (vehicle.kind) {
    case VehicleConfig::Kind::kWheeledCar:
      return std::make_unique<WheeledCar>(WheeledCarParams::ScaledTo(vehicle), time_step, environment.parameter_spread);
    case VehicleConfig::Kind::kPlaneCar:
      return std::make_unique<PlaneCar>(vehicle, time_step, environment.parameter_spread);
  }
  ThrowUsageError("vehicle.kind = {}: no such vehicle", static_cast<int>(vehicle.kind));
}

}  // namespace cairn::actors
