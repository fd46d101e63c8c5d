#include "planner/collision/ompl_space.h"

#include <gtest/gtest.h>
#include <ompl/base/ScopedState.h>

#include "common/world/reachability.h"
#include "tests/planner/test_worlds.h"

namespace cairn::planner {
namespace {

namespace ob = ompl::base;

class OmplSpaceTest : public testing::TestWithParam<int> {
 protected:
  World world_ = TwoRooms(GetParam());
  DistanceField field_{world_, 0.01};
  Reachability reachability_{world_, field_, 0.04};
  SweptSphereChecker checker_{world_, 0.04};
  FreeSpace space_{world_, checker_, reachability_};
};

TEST_P(OmplSpaceTest, SamplersRepeatWhateverOmplsGeneratorDoes) {
  const ob::SpaceInformationPtr information = MakeSpaceInformation(space_, 5);
  ob::ScopedState<> a(information), b(information);
  const auto first = information->allocValidStateSampler();
  ompl::RNG().uniform01();
  const auto second = information->allocValidStateSampler();
  const auto other = MakeSpaceInformation(space_, 6)->allocValidStateSampler();
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(first->sample(a.get()) && second->sample(b.get()));
    EXPECT_TRUE(a == b);
    EXPECT_TRUE(information->isValid(a.get()));
  }
  ASSERT_TRUE(other->sample(b.get()));
  EXPECT_FALSE(a == b);
}

TEST_P(OmplSpaceTest, SampleNearStaysNear) {
  const ob::SpaceInformationPtr information = MakeSpaceInformation(space_, 5);
  ob::ScopedState<> a(information), b(information);
  const auto sampler = information->allocValidStateSampler();
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(sampler->sample(a.get()) && sampler->sampleNear(b.get(), a.get(), 0.1));
    EXPECT_LE(information->distance(a.get(), b.get()), 0.1 + 1e-6);
  }
}

TEST_P(OmplSpaceTest, LastValidStateOfABlockedMotionIsFree) {
  const ob::SpaceInformationPtr information = MakeSpaceInformation(space_, 5);
  const double z = GetParam() == 3 ? 0.25 : 0;
  ob::ScopedState<> a(information), b(information), last(information);
  ToState(Vector3d(0.8, 0.2, z), GetParam(), a.get());
  ToState(Vector3d(1.2, 0.2, z), GetParam(), b.get());
  std::pair<ob::State*, double> last_valid(last.get(), -1);
  EXPECT_FALSE(information->checkMotion(a.get(), b.get(), last_valid));
  EXPECT_NEAR(ToPosition(last.get(), GetParam()).x(), 0.96, 1e-3);  // the wall less the radius
  EXPECT_NEAR(last_valid.second, 0.4, 3e-3);
  EXPECT_TRUE(information->checkMotion(a.get(), last.get()));
}

TEST_P(OmplSpaceTest, RegionGoalIsSatisfiedInsideOnly) {
  const ob::SpaceInformationPtr information = MakeSpaceInformation(space_, 5);
  const ob::GoalPtr goal = MakeRegionGoal(information, world_, world_.goal);
  ob::ScopedState<> state(information);
  ToState(Vector3d(1.8, 0.8, 0.2), GetParam(), state.get());
  EXPECT_TRUE(goal->isSatisfied(state.get()));
  ToState(Vector3d(1.8, 0.69, 0.2), GetParam(), state.get());
  EXPECT_FALSE(goal->isSatisfied(state.get()));
}

INSTANTIATE_TEST_SUITE_P(Dimensions, OmplSpaceTest, testing::Values(2, 3));

}  // namespace
}  // namespace cairn::planner
