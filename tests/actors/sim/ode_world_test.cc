#include "actors/sim/ode_world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <thread>
#include <vector>

#include "actors/sim/ode_library.h"
#include "common/core/check.h"

namespace cairn::actors {
namespace {

constexpr double kStep = 1.0 / 240;

TEST(OdeLibraryTest, InitialisesFromManyThreadsAtOnce) {
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i) threads.emplace_back(InitOde);
  for (std::thread& thread : threads) thread.join();
}

TEST(OdeLibraryTest, TurnsOdeErrorsIntoExceptions) {
  InitOde();
  try {
    dDebug(7, "wheel %d", 3);
    FAIL() << "returned";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "ODE error 7: wheel 3");
  }
}

// Semi-implicit Euler: after n steps v = −g n h and z = −g h² n (n + 1) / 2.
TEST(OdeWorldTest, FallsLikeSemiImplicitEuler) {
  OdeWorld world({});
  const dBodyID body = world.AddSphereBody(0.5, 0.1);
  for (int i = 0; i < 240; ++i) world.Step(kStep);
  EXPECT_NEAR(dBodyGetLinearVel(body)[2], -9.81, 1e-12);
  EXPECT_NEAR(dBodyGetPosition(body)[2], -9.81 * kStep * kStep * 240 * 241 / 2, 1e-12);
}

TEST(OdeWorldTest, FloorContactHasTheNumbersOfOdesOwnCollision) {
  OdeWorld world({});
  const dGeomID plane = dCreatePlane(nullptr, 0, 0, 1, 0);
  const dGeomID sphere = dCreateSphere(nullptr, 0.02);
  const dVector3 center{0.3, -0.2, 0.0195};
  dGeomSetPosition(sphere, center[0], center[1], center[2]);
  dContactGeom expected;
  ASSERT_EQ(dCollide(sphere, plane, 1, &expected, sizeof(expected)), 1);
  // Both ways the same body must move the same way.
  OdeWorld other({});
  const dBodyID ours = world.AddSphereBody(0.1, 0.02);
  const dBodyID theirs = other.AddSphereBody(0.1, 0.02);
  for (const dBodyID body : {ours, theirs}) {
    dBodySetPosition(body, center[0], center[1], center[2]);
    dBodySetLinearVel(body, 0.3, 0.1, -0.4);
  }
  world.AddFloorContact(ours, center, 0.02, {}, 1, 0);
  dContact contact{};
  contact.geom = expected;
  contact.surface.mode = dContactSoftERP | dContactSoftCFM | dContactApprox1 | dContactFDir1;
  contact.surface.mu = 1;
  contact.surface.soft_erp = 0.4;
  contact.surface.soft_cfm = 1e-5;
  contact.fdir1[0] = 1;
  dJointAttach(dJointCreateContact(other.id(), nullptr, &contact), theirs, nullptr);
  world.Step(kStep);
  other.Step(kStep);
  for (int i = 0; i < 3; ++i) {
    EXPECT_DOUBLE_EQ(dBodyGetLinearVel(ours)[i], dBodyGetLinearVel(theirs)[i]);
    EXPECT_DOUBLE_EQ(dBodyGetAngularVel(ours)[i], dBodyGetAngularVel(theirs)[i]);
  }
  dGeomDestroy(sphere);
  dGeomDestroy(plane);
}

TEST(OdeWorldTest, TheFloorCarriesTheWeight) {
  OdeWorld world({});
  const dBodyID body = world.AddSphereBody(0.25, 0.02);
  dBodySetPosition(body, 0, 0, 0.02);
  dJointFeedback feedback{};
  for (int i = 0; i < 240; ++i) {
    dJointSetFeedback(world.AddFloorContact(body, dBodyGetPosition(body), 0.02, {}, 1, 0), &feedback);
    world.Step(kStep);
  }
  EXPECT_NEAR(feedback.f1[2], 0.25 * 9.81, 1e-6);
  EXPECT_GE(dBodyGetPosition(body)[2], 0.02 - 1e-4);
}

TEST(OdeWorldTest, ASphereAboveTheFloorHasNoContact) {
  OdeWorld world({});
  const dBodyID body = world.AddSphereBody(0.25, 0.02);
  dBodySetPosition(body, 0, 0, 0.0201);
  EXPECT_EQ(world.AddFloorContact(body, dBodyGetPosition(body), 0.02, {}, 1, 0), nullptr);
}

// A frictionless contact keeps the sideways speed; one with μ = 1 turns sliding into rolling: a solid sphere pushed
// without spin ends at 5/7 of its speed (angular momentum about the contact).
TEST(OdeWorldTest, FrictionTurnsSlidingIntoRolling) {
  for (const double friction : {0.0, 1.0}) {
    OdeWorld world({});
    const dBodyID body = world.AddSphereBody(0.1, 0.02);
    dBodySetPosition(body, 0, 0, 0.02);
    dBodySetLinearVel(body, 0.7, 0, 0);
    FloorSurface surface;
    surface.friction = friction;
    for (int i = 0; i < 240; ++i) {
      world.AddFloorContact(body, dBodyGetPosition(body), 0.02, surface, 1, 0);
      world.Step(kStep);
    }
    EXPECT_NEAR(dBodyGetLinearVel(body)[0], friction == 0 ? 0.7 : 0.5, 2e-3) << friction;
  }
}

TEST(OdeWorldTest, LeavesNoContactBehind) {
  OdeWorld world({});
  const dBodyID body = world.AddSphereBody(0.1, 0.02);
  dBodySetPosition(body, 0, 0, 0.0199);
  world.AddFloorContact(body, dBodyGetPosition(body), 0.02, {}, 1, 0);
  EXPECT_EQ(dBodyGetNumJoints(body), 1);
  world.Step(kStep);
  EXPECT_EQ(dBodyGetNumJoints(body), 0);
}

TEST(OdeWorldTest, WorldsOfTwoThreadsDoNotDisturbEachOther) {
  const auto run = [] {
    OdeWorld world({});
    const dBodyID body = world.AddSphereBody(0.1, 0.02);
    dBodySetPosition(body, 0, 0, 0.5);
    dBodySetAngularVel(body, 5, 1, 0);
    for (int i = 0; i < 5000; ++i) {
      world.AddFloorContact(body, dBodyGetPosition(body), 0.02, {}, 1, 0);
      world.Step(kStep);
    }
    return std::vector<double>(dBodyGetPosition(body), dBodyGetPosition(body) + 3);
  };
  std::vector<double> first, second;
  std::thread a([&] { first = run(); });
  std::thread b([&] { second = run(); });
  a.join();
  b.join();
  EXPECT_EQ(first, second);
  EXPECT_EQ(first, run());
}

TEST(OdeWorldTest, BodyStateRoundTripsBitForBit) {
  OdeWorld world({});
  const dVector3 size{0.1, 0.05, 0.02};
  const dBodyID body = world.AddBoxBody(0.2, size);
  dBodySetAngularVel(body, 1, 2, 3);
  for (int i = 0; i < 100; ++i) world.Step(kStep);
  BlobWriter writer;
  WriteBody(body, writer);
  const std::string blob = writer.Take();
  for (int i = 0; i < 100; ++i) world.Step(kStep);
  BlobReader reader(blob);
  ReadBody(body, reader);
  reader.Finish();
  BlobWriter again;
  WriteBody(body, again);
  EXPECT_EQ(again.Take(), blob);
}

}  // namespace
}  // namespace cairn::actors
