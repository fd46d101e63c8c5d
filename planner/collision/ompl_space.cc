#include "planner/collision/ompl_space.h"

#include <ompl/base/MotionValidator.h>
#include <ompl/base/ScopedState.h>
#include <ompl/base/StateValidityChecker.h>
#include <ompl/base/ValidStateSampler.h>
#include <ompl/base/goals/GoalRegion.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "common/world/signed_distance.h"

namespace cairn::planner {
namespace {

namespace ob = ompl::base;

class Validity : public ob::StateValidityChecker {
 public:
  Validity(const ob::SpaceInformationPtr& information, const FreeSpace& space)
      : ob::StateValidityChecker(information), space_(space) {
    specs_.clearanceComputationType = ob::StateValidityCheckerSpecs::NONE;
  }
  bool isValid(const ob::State* state) const override {
    return space_.checker().Free(ToPosition(state, space_.world().dimension));
  }

 private:
  const FreeSpace& space_;
};

class Motion : public ob::MotionValidator {
 public:
  Motion(const ob::SpaceInformationPtr& information, const FreeSpace& space)
      : ob::MotionValidator(information), space_(space) {}

  bool checkMotion(const ob::State* a, const ob::State* b) const override {
    const int dimension = space_.world().dimension;
    return space_.checker().MotionFree(ToPosition(a, dimension), ToPosition(b, dimension));
  }

  // OMPL asks for a valid state on the way when the motion is not: halves the interval ten times.
  bool checkMotion(const ob::State* a, const ob::State* b, std::pair<ob::State*, double>& last_valid) const override {
    if (checkMotion(a, b)) return true;
    const int dimension = space_.world().dimension;
    const Vector3d from = ToPosition(a, dimension), to = ToPosition(b, dimension);
    double good = 0, bad = 1;
    for (int i = 0; i < 10; ++i) {
      const double middle = 0.5 * (good + bad);
      (space_.checker().MotionFree(from, from + middle * (to - from)) ? good : bad) = middle;
    }
    if (last_valid.first) ToState(from + good * (to - from), dimension, last_valid.first);
    last_valid.second = good;
    return false;
  }

 private:
  const FreeSpace& space_;
};

class Sampler : public ob::ValidStateSampler {
 public:
  Sampler(const ob::SpaceInformation* information, const FreeSpace& space, uint64_t seed)
      : ob::ValidStateSampler(information), space_(space), random_(seed, RandomPurpose::kPlanner) {}

  bool sample(ob::State* state) override { return Store(space_.Draw(random_), state); }

  // OMPL's contract: within `distance` of `near`; the box around it, cut to the bounds, is drawn from.
  bool sampleNear(ob::State* state, const ob::State* near, double distance) override {
    const World& world = space_.world();
    const Vector3d center = ToPosition(near, world.dimension);
    const double half = distance / std::sqrt(world.dimension);
    const Box region{(center.array() - half).matrix().cwiseMax(world.bounds.min),
                     (center.array() + half).matrix().cwiseMin(world.bounds.max)};
    return Store(space_.Draw(region, random_), state);
  }

 private:
  bool Store(const std::optional<Vector3d>& p, ob::State* state) const {
    if (p) ToState(*p, space_.world().dimension, state);
    return p.has_value();
  }

  const FreeSpace& space_;
  RandomStream random_;
};

// What lies between states is rounded as states are, so that a tree's motions are tested as a roadmap stores them.
class FloatSpace : public ob::RealVectorStateSpace {
 public:
  using ob::RealVectorStateSpace::RealVectorStateSpace;
  void interpolate(const ob::State* from, const ob::State* to, double t, ob::State* state) const override {
    ob::RealVectorStateSpace::interpolate(from, to, t, state);
    const auto dimension = static_cast<int>(getDimension());
    ToState(RoundToFloat(ToPosition(state, dimension), dimension), dimension, state);
  }
};

class RegionGoal : public ob::GoalRegion {
 public:
  RegionGoal(const ob::SpaceInformationPtr& information, int dimension, const Box& region)
      : ob::GoalRegion(information), dimension_(dimension), region_(region) {
    setThreshold(std::numeric_limits<double>::min());  // OMPL asks for distance < threshold, inside it is 0
  }
  double distanceGoal(const ob::State* state) const override {
    return std::max(0.0, SignedDistance(region_, ToPosition(state, dimension_), dimension_));
  }

 private:
  int dimension_;
  Box region_;
};

}  // namespace

Vector3d ToPosition(const ob::State* state, int dimension) {
  const double* v = state->as<ob::RealVectorStateSpace::StateType>()->values;
  return Vector3d(v[0], v[1], dimension == 3 ? v[2] : 0);
}

void ToState(const Vector3d& p, int dimension, ob::State* state) {
  double* v = state->as<ob::RealVectorStateSpace::StateType>()->values;
  for (int k = 0; k < dimension; ++k) v[k] = p[k];
}

ob::SpaceInformationPtr MakeSpaceInformation(const FreeSpace& space, uint64_t seed) {
  const World& world = space.world();
  const auto state_space = std::make_shared<FloatSpace>(world.dimension);
  ob::RealVectorBounds bounds(world.dimension);
  for (int k = 0; k < world.dimension; ++k) {
    bounds.setLow(k, world.bounds.min[k]);
    bounds.setHigh(k, world.bounds.max[k]);
  }
  state_space->setBounds(bounds);
  auto information = std::make_shared<ob::SpaceInformation>(state_space);
  information->setStateValidityChecker(std::make_shared<Validity>(information, space));
  information->setMotionValidator(std::make_shared<Motion>(information, space));
  information->setValidStateSamplerAllocator(
      [&space, seed](const ob::SpaceInformation* owner) { return std::make_shared<Sampler>(owner, space, seed); });
  information->setup();
  return information;
}

ob::GoalPtr MakeRegionGoal(const ob::SpaceInformationPtr& information, const World& world, const Box& region) {
  return std::make_shared<RegionGoal>(information, world.dimension, region);
}

ob::ProblemDefinitionPtr MakeProblem(const ob::SpaceInformationPtr& information, const std::vector<Vector3d>& starts,
                                     const ob::GoalPtr& goal) {
  auto problem = std::make_shared<ob::ProblemDefinition>(information);
  ob::ScopedState<> state(information);
  for (const Vector3d& start : starts) {
    ToState(start, static_cast<int>(information->getStateDimension()), state.get());
    problem->addStartState(state);
  }
  problem->setGoal(goal);
  return problem;
}

}  // namespace cairn::planner
