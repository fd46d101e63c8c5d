#include "common/world/world_variants.h"

#include <algorithm>
#include <cmath>

#include "common/core/check.h"
#include "common/core/random.h"
#include "common/world/distance_field.h"
#include "common/world/reachability.h"

namespace cairn {
namespace {

constexpr int kMaxDraws = 1000;
constexpr int kProbes = 500;
constexpr double kMaxNodes = 500000;
// Which part of the free space must still reach the goal when doors are closed at random.
constexpr double kDoorShare = 0.5;

// Points of the start space from which the goal can be reached, to see what a change cuts off. Fields are coarse here,
// a third of the radius, and the radius that they are asked for so much larger that what passes passes.
class Passages {
 public:
  Passages(const World& world, double radius, RandomStream& random) : radius_(radius) {
    resolution_ = std::max(radius / 3, Coarsest(world));
    const DistanceField field(world, resolution_);
    const Reachability reachability(world, field, radius_);
    for (int draw = 0; draw < 100 * kProbes && static_cast<int>(probes_.size()) < kProbes; ++draw) {
      Vector3d p = Vector3d::Zero();
      for (int k = 0; k < world.dimension; ++k) {
        p[k] = random.Uniform(world.start_space.min[k], world.start_space.max[k]);
      }
      if (field.Distance(p) >= radius_ && reachability.Reaches(p)) probes_.push_back(p);
    }
  }

  // Share of the points, those covered by a new obstacle left out, from which the goal can still be reached; 0 when
  // nobody fits into the goal any more.
  double Share(const World& world) const {
    const DistanceField field(world, resolution_);
    try {
      const Reachability reachability(world, field, radius_);
      int free = 0, reached = 0;
      for (const Vector3d& p : probes_) {
        if (field.Distance(p) < radius_) continue;
        ++free;
        reached += reachability.Reaches(p);
      }
      return free == 0 ? 0 : static_cast<double>(reached) / free;
    } catch (const UsageError&) {
      return 0;
    }
  }

 private:
  static double Coarsest(const World& world) {
    double volume = 1;
    for (int k = 0; k < world.dimension; ++k) volume *= world.bounds.size()[k];
    return std::pow(volume / kMaxNodes, 1.0 / world.dimension);
  }

  double radius_;
  double resolution_;
  std::vector<Vector3d> probes_;
};

World WithBoxes(World world, const std::vector<Box>& boxes) {
  world.boxes.insert(world.boxes.end(), boxes.begin(), boxes.end());
  return world;
}

std::vector<Box> ListedDoors(const World& world, const std::vector<int>& numbers) {
  std::vector<Box> doors;
  for (const int number : numbers) {
    if (number < 0 || number >= static_cast<int>(world.doors.size())) {
      ThrowUsageError("world.blocked_doors: {} is no door's number; this world has {} doors, from 0 on", number,
                      world.doors.size());
    }
    doors.push_back(world.doors[static_cast<size_t>(number)]);
  }
  return doors;
}

// Doors whose middles are at the height of door `like` (in the plane all are).
std::vector<int> DoorsOfFloor(const World& world, int like) {
  const auto height = [&](int door) { return world.doors[static_cast<size_t>(door)].center().z(); };
  std::vector<int> doors;
  for (int door = 0; door < static_cast<int>(world.doors.size()); ++door) {
    if (world.dimension == 2 || std::abs(height(door) - height(like)) < 1e-9) doors.push_back(door);
  }
  return doors;
}

size_t MostDoorsOfAFloor(const World& world) {
  size_t most = 0;
  for (int door = 0; door < static_cast<int>(world.doors.size()); ++door) {
    most = std::max(most, DoorsOfFloor(world, door).size());
  }
  return most;
}

std::vector<Box> RandomDoors(const World& world, int count, double radius, RandomStream& random) {
  if (count == 0) return {};
  if (static_cast<size_t>(count) > MostDoorsOfAFloor(world)) {
    ThrowUsageError("world.random_blocked_doors = {}: no floor of this world has more than {} doors", count,
                    MostDoorsOfAFloor(world));
  }
  const Passages passages(world, radius, random);
  for (int draw = 0; draw < kMaxDraws; ++draw) {
    std::vector<int> floor =
        DoorsOfFloor(world, static_cast<int>(random.Below(static_cast<uint32_t>(world.doors.size()))));
    if (static_cast<int>(floor.size()) < count) continue;
    std::vector<Box> doors;
    for (size_t i = 0; i < static_cast<size_t>(count); ++i) {  // partial Fisher-Yates
      std::swap(floor[i], floor[i + random.Below(static_cast<uint32_t>(floor.size() - i))]);
      doors.push_back(world.doors[static_cast<size_t>(floor[i])]);
    }
    if (passages.Share(WithBoxes(world, doors)) >= kDoorShare) return doors;
  }
  ThrowUsageError("world.random_blocked_doors = {}: {} draws found none that leave the goal to half of the starts",
                  count, kMaxDraws);
}

// Cubes (squares) of random sides about the given one, anywhere but at the goal, each leaving every passage open.
std::vector<Box> UnseenObstacles(const World& world, const WorldConfig& config, double radius, RandomStream& random) {
  std::vector<Box> added;
  if (config.unseen_obstacles == 0) return added;
  const Passages passages(world, radius, random);
  for (int draw = 0; static_cast<int>(added.size()) < config.unseen_obstacles; ++draw) {
    if (draw == kMaxDraws) {
      ThrowUsageError(
          "world.unseen_obstacles = {}: {} draws found room for {} of side {} m that leave every passage open",
          config.unseen_obstacles, kMaxDraws, added.size(), config.unseen_obstacle_size);
    }
    const double half = 0.5 * config.unseen_obstacle_size * random.Uniform(0.7, 1.3);
    Box box;
    bool at_goal = true;
    for (int k = 0; k < world.dimension; ++k) {
      const double center = random.Uniform(world.bounds.min[k], world.bounds.max[k]);
      box.min[k] = center - half;
      box.max[k] = center + half;
      at_goal = at_goal && box.max[k] > world.goal.min[k] - radius && box.min[k] < world.goal.max[k] + radius;
    }
    if (at_goal) continue;
    added.push_back(box);
    if (passages.Share(WithBoxes(world, added)) < 1) added.pop_back();
  }
  return added;
}

void CheckDimension(const VehicleConfig& vehicle, const World& world) {
  if (vehicle.dimension() == world.dimension) return;
  ThrowUsageError("vehicle.kind: {}, but the world is {}{}",
                  vehicle.dimension() == 3 ? "a QUADROTOR flies" : "it drives in the plane (only a QUADROTOR flies)",
                  world.dimension == 3 ? "in space" : "plane",
                  world.imported && world.dimension == 3
                      ? "; world.slice_min and world.slice_max make a plane map of the heights that it can touch"
                      : "");
}

}  // namespace

WorldVariants MakeWorldVariants(const Experiment& experiment) {
  WorldVariants variants = MakeWorldVariants(experiment.world, experiment.planner.radius);
  CheckDimension(experiment.vehicle, variants.known);
  return variants;
}

WorldVariants MakeWorldVariants(const WorldConfig& config, double radius) {
  const World world = MakeWorld(config);
  RandomStream random(config.seed, RandomPurpose::kWorld, 1);
  std::vector<Box> closed = ListedDoors(world, config.blocked_doors);
  const std::vector<Box> drawn = RandomDoors(WithBoxes(world, closed), config.random_blocked_doors, radius, random);
  closed.insert(closed.end(), drawn.begin(), drawn.end());
  const World blocked = WithBoxes(world, closed);
  WorldVariants variants;
  variants.known = config.blocked_known ? blocked : world;
  variants.training = config.blocked_when == WorldConfig::BlockedWhen::kAlways ? blocked : world;
  variants.evaluation = WithBoxes(blocked, UnseenObstacles(blocked, config, radius, random));
  variants.same = variants.evaluation.boxes.size() == world.boxes.size();
  return variants;
}

}  // namespace cairn
