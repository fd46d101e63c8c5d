#include "actors/persons.h"

#include <gtest/gtest.h>

#include <cmath>

#include "actors/contact_test.h"
#include "tests/actors/test_scene.h"

namespace cairn::actors {
namespace {

// The hall with a way along y = 0.5 from x = 0.5 to 2.7 and a person of 5 cm who makes 0.2 m/s.
class PersonsTest : public ::testing::Test {
 protected:
  PersonsTest() {
    experiment_ = HallExperiment();
    experiment_.world.persons = 1;
    experiment_.world.person_radius = 0.05;
    experiment_.world.person_speed = 0.2;
    experiment_.world.persons_when = WorldConfig::BlockedWhen::kAlways;
    scene_ = std::make_shared<Scene>(experiment_);
    scene_->SetTable(MakeChain(scene_->world().goal, {0.5f, 1.0f, 1.5f, 2.0f, 2.5f, 2.7f}, 0.5f, 0.05));
  }

  static RandomStream Stream(uint32_t episode) { return {1, RandomPurpose::kPersons, 0, episode}; }

  static Vector3d Place(const Persons& persons) { return persons.bodies().at(0).base; }

  Experiment experiment_;
  std::shared_ptr<Scene> scene_;
  const Vector3d start_{0.5, 0.5, 0};
};

TEST_F(PersonsTest, WalkToAndFroAtTheirSpeed) {
  Persons persons(*scene_);
  const double keep_clear = 4 * experiment_.vehicle.circumscribed_radius() + 0.05;
  for (uint32_t episode = 0; episode < 20; ++episode) {
    persons.Reset(start_, true, Stream(episode));
    double low = 9, high = 0, last = Place(persons).x();
    for (int i = 0; i < 600; ++i) {
      persons.Walk(0.1, {0.1, 0.1, 0});
      const Vector3d p = Place(persons);
      EXPECT_NEAR(p.y(), 0.5, 1e-6);
      EXPECT_LE(std::abs(p.x() - last), 0.02 + 1e-6);
      last = p.x();
      low = std::min(low, last), high = std::max(high, last);
    }
    EXPECT_NEAR(low, 0.5 + keep_clear, 0.025);
    EXPECT_NEAR(high, 2.7 - keep_clear, 0.045);
  }
}

TEST_F(PersonsTest, AreSeenByRaysAndFeltOnContact) {
  Persons persons(*scene_);
  persons.Reset(start_, true, Stream(1));
  const Vector3d p = Place(persons);
  EXPECT_NEAR(persons.CastRay(p - Vector3d(0.3, 0, 0), {1, 0, 0}, 1), 0.25, 1e-9);
  EXPECT_NEAR(persons.CastRay(p - Vector3d(0.3, 0.03, 0), {1, 0, 0}, 1), 0.3 - 0.04, 1e-9);
  EXPECT_EQ(persons.CastRay(p - Vector3d(0.3, 0.06, 0), {1, 0, 0}, 1), 1);
  EXPECT_EQ(persons.CastRay(p + Vector3d(0.3, 0, 0), {1, 0, 0}, 1), 1);
  const ContactTest contact(*scene_, &persons);
  const auto touches = [&](double x, double y, double yaw) {
    const GroundState state{p.x() + x, p.y() + y, yaw};
    return contact.Touches(state, contact.CenterDistance(state));
  };
  EXPECT_FALSE(touches(-0.035 - 0.051, 0, 0));
  EXPECT_TRUE(touches(-0.035 - 0.049, 0, 0));
  EXPECT_FALSE(touches(0, 0.025 + 0.051, 0));
  EXPECT_TRUE(touches(0, 0.025 + 0.049, 0));
  EXPECT_FALSE(touches(0, 0.025 + 0.049 + 0.012, M_PI / 2));
}

TEST_F(PersonsTest, AreAbsentWhereTheWayIsTooShortOrNobodyIsAskedFor) {
  Persons persons(*scene_);
  persons.Reset(start_, false, Stream(0));
  EXPECT_TRUE(persons.empty());
  EXPECT_TRUE(std::isinf(persons.Distance(start_)));
  persons.Reset({2.4, 0.5, 0}, true, Stream(0));
  EXPECT_TRUE(persons.empty());
}

TEST_F(PersonsTest, WaitForAVehicleThatStandsInTheirWay) {
  Persons persons(*scene_);
  persons.Reset(start_, true, Stream(2));
  const Vector3d vehicle(1.6, 0.5, 0);
  double nearest = 9;
  for (int i = 0; i < 400; ++i) {
    persons.Walk(0.1, vehicle);
    nearest = std::min(nearest, (Place(persons) - vehicle).norm());
  }
  EXPECT_NEAR(nearest, 1.25 * experiment_.vehicle.circumscribed_radius() + 0.05, 0.021);
}

TEST_F(PersonsTest, AreHitByAVehicleThatDrivesIntoThem) {
  Environment environment(scene_);
  int hit = 0;
  for (int episode = 0; episode < 60; ++episode) {
    environment.ResetTraining(0, episode);
    if (environment.persons().empty()) continue;
    EXPECT_GT((environment.persons()[0].base - Vector3d(environment.pose().x, environment.pose().y, 0)).norm(), 0.2);
    const Action ahead(1, 0);
    while (environment.Step(ahead.data()).end == SegmentEnd::kNone) {
    }
    const Cylinder& body = environment.persons()[0];
    const double gap = std::hypot(body.base.x() - environment.pose().x, body.base.y() - environment.pose().y);
    hit += environment.episode().outcome == Outcome::kCollision && gap < 0.05 + 0.045;
  }
  EXPECT_GE(hit, 1);
}

}  // namespace
}  // namespace cairn::actors
