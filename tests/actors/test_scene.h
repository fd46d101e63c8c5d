#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "actors/environment.h"
#include "actors/scene.h"
#include "tests/testing/grid_roadmap.h"

namespace cairn::actors {

/// Commands of a car: speed and yaw rate.
constexpr int kCarActions = 2;

/// Motion of a ground vehicle, in the order that tests write it.
struct GroundState {
  double x = 0, y = 0, yaw = 0, speed = 0, yaw_rate = 0;
  operator Motion() const { return {x, y, 0, yaw, speed, 0, 0, yaw_rate}; }  // NOLINT(google-explicit-constructor)
};

/// An empty hall, x 0…3 m, y 0…1 m; start region on the left, goal region x 2.6…2.9, y 0.3…0.7. No disturbance and a
/// plane car without lag: what happens can be worked out by hand.
inline Experiment HallExperiment() {
  Experiment experiment;
  WorldConfig& world = experiment.world;
  world.kind = WorldConfig::Kind::kBoxes;
  world.bounds = {{0, 0, 0}, {3, 1, 0}};
  world.start = {{0.1, 0.1, 0}, {0.5, 0.9, 0}};
  world.goal = {{2.6, 0.3, 0}, {2.9, 0.7, 0}};
  world.field_resolution = 0.005;
  experiment.vehicle.kind = VehicleConfig::Kind::kPlaneCar;
  experiment.vehicle.lag = 0;
  experiment.environment.speed_disturbance = 0;
  experiment.environment.yaw_rate_disturbance = 0;
  experiment.environment.max_episode_steps = 200;
  return experiment;
}

/// The paper's maze with everything random switched on.
inline Experiment NoisyMazeExperiment() {
  Experiment experiment;
  experiment.environment.observation_noise = 0.05;
  experiment.environment.action_delay_steps = 2;
  experiment.environment.parameter_spread = 0.1;
  experiment.environment.action_delay = 0.03;
  experiment.environment.action_delay_spread = 0.03;
  experiment.environment.slip = 0.2;
  experiment.environment.footprint_spread = 0.1;
  experiment.observation.pose_noise = 0.005;
  experiment.observation.heading_noise = 0.05;
  experiment.observation.pose_jump = 0.005;
  experiment.observation.pose_jump_interval = 0.5;
  experiment.observation.pose_filter = 0.3;
  experiment.observation.range_noise = 0.002;
  experiment.observation.range_dropout = 0.02;
  experiment.observation.last_actions = 2;
  experiment.world.persons = 2;
  experiment.world.persons_when = WorldConfig::BlockedWhen::kAlways;
  experiment.safety.filter = SafetyConfig::Filter::kAlways;
  experiment.safety.beams = 40;
  return experiment;
}

inline std::shared_ptr<Scene> MakeScene(const Experiment& experiment, double spacing = 0.025) {
  auto scene = std::make_shared<Scene>(experiment);
  scene->SetTable(testing::MakeGridLookup(scene->world(), scene->field(), spacing, experiment.planner.radius,
                                          experiment.planner.r_ball()));
  return scene;
}

/// Vertices on the line y, at these x, each leading to the next; the last is the goal's.
inline std::shared_ptr<const RoadmapLookup> MakeChain(const Box& goal, const std::vector<float>& xs, float y,
                                                      double r_ball) {
  CostTable table{1, goal, std::vector<float>(xs.size(), 0), std::vector<int32_t>(xs.size(), -1)};
  std::vector<float> positions;
  for (const float x : xs) positions.insert(positions.end(), {x, y});
  for (size_t i = xs.size() - 1; i-- > 0;) {
    table.cost[i] = table.cost[i + 1] + (xs[i + 1] - xs[i]);
    table.next_vertex[i] = static_cast<int32_t>(i + 1);
  }
  return std::make_shared<RoadmapLookup>(2, positions, table, r_ball);
}

/// The action for a forward speed and yaw rate under the default limits (0…1 m/s, ±2 rad/s).
struct Action {
  float values[kCarActions];
  Action(double speed, double yaw_rate) : values{static_cast<float>(2 * speed - 1), static_cast<float>(yaw_rate / 2)} {}
  const float* data() const { return values; }
};

/// Points the environment's vehicle the way a test needs: drives an evaluation start index whose pose satisfies
/// `accept`; −1 when none of the first 10,000 does.
template <typename Accept>
int FindEvaluationStart(const Scene& scene, const Accept& accept) {
  for (int index = 0; index < 10000; ++index) {
    if (accept(scene.EvaluationStart(StartSet::kTest, index))) return index;
  }
  return -1;
}

inline std::vector<float> Observe(const Environment& environment) {
  std::vector<float> out(static_cast<size_t>(ObservationSize(environment.scene().experiment())));
  environment.Observe(out.data());
  return out;
}

/// An evaluation start in the hall from which straight ahead leads to the wall at x = 0 (facing −x within 0.1 rad).
inline int StartTowardsWall(const Scene& scene) {
  return FindEvaluationStart(scene, [](const Pose& p) {
    return std::abs(std::remainder(p.yaw - M_PI, 2 * M_PI)) < 0.05 && p.x > 0.3 && p.x < 0.6 && p.y > 0.3 && p.y < 0.7;
  });
}

/// One that faces the goal region from 0.5 to 1 m before it.
inline int StartTowardsGoal(const Scene& scene) {
  return FindEvaluationStart(
      scene, [](const Pose& p) { return std::abs(p.yaw) < 0.05 && p.x > 1.6 && p.x < 2.1 && p.y > 0.4 && p.y < 0.6; });
}

}  // namespace cairn::actors
