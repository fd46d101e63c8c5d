#pragma once

#include <ode/ode.h>

#include "actors/blob.h"

namespace cairn::actors {

/// Constants of an ODE world. They scale with the vehicle: see CarParams.
struct OdeWorldParams {
  double gravity = 9.81;                 ///< along −z [m/s²]
  double cfm = 1e-5;                     ///< world constraint force mixing; 0 makes the solver print internal errors
  double contact_surface_layer = 1e-4;   ///< depth at which contacts rest [m]
  double max_correcting_velocity = 0.5;  ///< of contacts [m/s]
};

/// How a sphere meets the floor.
struct FloorSurface {
  double friction = 1.0;   ///< Coulomb μ, pyramid with the normal force of this step (dContactApprox1); 0: no rows
  double soft_erp = 0.4;   ///< share of the depth corrected a step
  double soft_cfm = 1e-5;  ///< [s/kg]
  double speed = 0;        ///< backwards, of a sphere that turns beside its body: what the body does without slip [m/s]
  double slip = 0;         ///< of that speed with the force that drives it [m/s/N]; 0: the world's cfm
  double height = 0;       ///< at which friction acts on the body [m]: above 0 for what turns freely beside it
};

/// An ODE world with its own threading implementation, so that worlds of different threads do not share one (they
/// share a default that crashes), and one group of contacts that lives for one step. Owns all bodies and joints made
/// in it. One thread at a time.
class OdeWorld {
 public:
  explicit OdeWorld(const OdeWorldParams& params);
  ~OdeWorld();
  OdeWorld(const OdeWorld&) = delete;
  OdeWorld& operator=(const OdeWorld&) = delete;

  dWorldID id() const { return world_; }

  /// A sphere's mass and inertia [kg, m]; gyroscopic terms off (they are exactly zero).
  dBodyID AddSphereBody(double mass, double radius);
  /// A solid box's mass and inertia; gyroscopic terms off: our boxes turn about a principal axis.
  dBodyID AddBoxBody(double mass, const dVector3 size);

  /// Contact of a sphere of `radius` [m] centred at `center` (W) and fixed to `body` with the floor z = 0, for the next
  /// step only; the same numbers as dCollide on a sphere and a plane, without geoms or spaces. Null when apart.
  /// The friction pyramid's sides lie along the level unit vector (`along_x`, `along_y`) and across it.
  dJointID AddFloorContact(dBodyID body, const dReal* center, double radius, const FloorSurface& surface,
                           double along_x, double along_y);

  /// Advances by dt [s] (dWorldStep: bit-exact without seeding and faster than QuickStep here), drops the contacts.
  void Step(double dt);

 private:
  dBodyID AddBody(const dMass& mass);

  dWorldID world_;
  dThreadingImplementationID threading_;
  dJointGroupID contacts_;
};

/// Writes a body's full state; ReadBody restores it bit for bit (dBodySetQuaternion alone would renormalise).
void WriteBody(dBodyID body, BlobWriter& blob);
void ReadBody(dBodyID body, BlobReader& blob);

/// Body at rest at a position with a rotation about W's z axis [rad], no force.
void PlaceBody(dBodyID body, double x, double y, double z, double yaw);

/// Yaw [rad] of a body: heading of its x axis in the plane.
double BodyYaw(dBodyID body);

}  // namespace cairn::actors
