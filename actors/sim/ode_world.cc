#include "actors/sim/ode_world.h"

#include <algorithm>
#include <cmath>

#include "actors/sim/ode_library.h"

namespace cairn::actors {

OdeWorld::OdeWorld(const OdeWorldParams& params) {
  InitOde();
  world_ = dWorldCreate();
  threading_ = dThreadingAllocateSelfThreadedImplementation();
  dWorldSetStepThreadingImplementation(world_, dThreadingImplementationGetFunctions(threading_), threading_);
  contacts_ = dJointGroupCreate(0);
  dWorldSetGravity(world_, 0, 0, -params.gravity);
  dWorldSetCFM(world_, params.cfm);
  dWorldSetContactSurfaceLayer(world_, params.contact_surface_layer);
  dWorldSetContactMaxCorrectingVel(world_, params.max_correcting_velocity);
}

OdeWorld::~OdeWorld() {
  dJointGroupDestroy(contacts_);
  dWorldDestroy(world_);
  dThreadingFreeImplementation(threading_);  // the world uses it until it is gone
}

dBodyID OdeWorld::AddSphereBody(double mass, double radius) {
  dMass m;
  dMassSetSphereTotal(&m, mass, radius);
  return AddBody(m);
}

dBodyID OdeWorld::AddBoxBody(double mass, const dVector3 size) {
  dMass m;
  dMassSetBoxTotal(&m, mass, size[0], size[1], size[2]);
  return AddBody(m);
}

dBodyID OdeWorld::AddBody(const dMass& mass) {
  const dBodyID body = dBodyCreate(world_);
  dBodySetMass(body, &mass);
  dBodySetGyroscopicMode(body, 0);
  return body;
}

dJointID OdeWorld::AddFloorContact(dBodyID body, const dReal* center, double radius, const FloorSurface& surface,
                                   double along_x, double along_y) {
  const double depth = radius - center[2];
  if (!(depth >= 0)) return nullptr;
  dContact contact{};
  contact.surface.mode = dContactSoftERP | dContactSoftCFM | dContactApprox1 | dContactFDir1;
  contact.surface.mu = surface.friction;
  if (surface.speed != 0) {
    contact.surface.mode |= dContactMotion1;
    contact.surface.motion1 = surface.speed;
  }
  if (surface.slip > 0) {
    contact.surface.mode |= dContactSlip1;
    contact.surface.slip1 = surface.slip;
  }
  contact.surface.soft_erp = surface.soft_erp;
  contact.surface.soft_cfm = surface.soft_cfm;
  contact.geom.pos[0] = center[0];
  contact.geom.pos[1] = center[1];
  contact.geom.pos[2] = center[2] - radius + surface.height;
  contact.geom.normal[2] = 1;
  contact.geom.depth = depth;
  contact.fdir1[0] = along_x;
  contact.fdir1[1] = along_y;
  const dJointID joint = dJointCreateContact(world_, contacts_, &contact);
  dJointAttach(joint, body, nullptr);
  return joint;
}

void OdeWorld::Step(double dt) {
  dWorldStep(world_, dt);
  dJointGroupEmpty(contacts_);
}

namespace {
struct BodyState {
  dVector3 position;
  dQuaternion quaternion;
  dMatrix3 rotation;
  dVector3 linear_velocity;
  dVector3 angular_velocity;
};
}  // namespace

void WriteBody(dBodyID body, BlobWriter& blob) {
  BodyState state{};
  std::copy_n(dBodyGetPosition(body), 3, state.position);
  std::copy_n(dBodyGetQuaternion(body), 4, state.quaternion);
  std::copy_n(dBodyGetRotation(body), 12, state.rotation);
  std::copy_n(dBodyGetLinearVel(body), 3, state.linear_velocity);
  std::copy_n(dBodyGetAngularVel(body), 3, state.angular_velocity);
  blob.Put(state);
}

void ReadBody(dBodyID body, BlobReader& blob) {
  BodyState state;
  blob.Get(state);
  dBodySetPosition(body, state.position[0], state.position[1], state.position[2]);
  // The getters point into the body: writing there is the only way past renormalisation.
  std::copy_n(state.quaternion, 4, const_cast<dReal*>(dBodyGetQuaternion(body)));
  std::copy_n(state.rotation, 12, const_cast<dReal*>(dBodyGetRotation(body)));
  dBodySetLinearVel(body, state.linear_velocity[0], state.linear_velocity[1], state.linear_velocity[2]);
  dBodySetAngularVel(body, state.angular_velocity[0], state.angular_velocity[1], state.angular_velocity[2]);
  dBodySetForce(body, 0, 0, 0);
  dBodySetTorque(body, 0, 0, 0);
}

void PlaceBody(dBodyID body, double x, double y, double z, double yaw) {
  const dQuaternion q{std::cos(0.5 * yaw), 0, 0, std::sin(0.5 * yaw)};
  dBodySetPosition(body, x, y, z);
  dBodySetQuaternion(body, q);
  dBodySetLinearVel(body, 0, 0, 0);
  dBodySetAngularVel(body, 0, 0, 0);
  dBodySetForce(body, 0, 0, 0);
  dBodySetTorque(body, 0, 0, 0);
}

double BodyYaw(dBodyID body) {
  const dReal* rotation = dBodyGetRotation(body);  // 3 × 4, row-major
  return std::atan2(rotation[4], rotation[0]);
}

}  // namespace cairn::actors
