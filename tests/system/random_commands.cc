// Drives one vehicle of one kind under random commands and looks after every control step whether something is wrong:
//   cairn-random-commands KIND [--steps N, default 20000] [--seed S]
// KIND is one of Vehicle.Kind in lower case. Commands are drawn anew in every step, held, or jump between their limits;
// mass and friction are spread, commands delayed and disturbed. Wrong is: an observation, reward or motion that is not
// finite, a diverged episode, a footprint inside an obstacle while the episode goes on, a centre that went through one
// (each against every obstacle, by means of this file alone), memory that grows after the first tenth. Exit status 1
// then.
#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "actors/environment.h"
#include "common/config/load.h"
#include "common/core/check.h"
#include "tests/testing/grid_roadmap.h"

namespace cairn::actors {
namespace {

constexpr double kRounding = 1e-9;        // [m]
constexpr long kMemoryGrowth = 2 * 1024;  // pages of the allocator, not of a leak [kB]

struct Options {
  std::string kind;
  int64_t steps = 20000;
  uint64_t seed = 1;
};

struct Sums {
  int64_t steps = 0, episodes = 0, goals = 0, collisions = 0, timeouts = 0;
  double top_speed = 0, way = 0;
};

long ResidentKb() {
  std::ifstream file("/proc/self/statm");
  long total = 0, resident = 0;
  file >> total >> resident;
  return resident * (sysconf(_SC_PAGESIZE) / 1024);
}

// How deep a rectangle turned by `yaw` reaches into an upright box: the least overlap over the sides' directions,
// negative when apart (separating axes).
double RectangleDepth(const Motion& m, double half_length, double half_width, const Box& box) {
  const double c = std::cos(m.yaw), s = std::sin(m.yaw);
  const Vector3d center = box.center(), half = 0.5 * box.size();
  const double dx = m.x - center.x(), dy = m.y - center.y();
  double depth = std::numeric_limits<double>::infinity();
  for (const auto& [ax, ay] : {std::pair{1.0, 0.0}, {0.0, 1.0}, {c, s}, {-s, c}}) {
    const double own = half_length * std::abs(ax * c + ay * s) + half_width * std::abs(ay * c - ax * s);
    const double its = half.x() * std::abs(ax) + half.y() * std::abs(ay);
    depth = std::min(depth, own + its - std::abs(dx * ax + dy * ay));
  }
  return depth;
}

double BallDepth(const World& world, const Vector3d& p, double radius, const Box& box) {
  double squares = 0;
  for (int k = 0; k < world.dimension; ++k) {
    squares += std::pow(std::max({box.min[k] - p[k], 0.0, p[k] - box.max[k]}), 2);
  }
  return radius - std::sqrt(squares);
}

bool InsideObstacle(const Scene& scene, const Motion& m) {
  const World& world = scene.world();
  const Footprint& f = scene.footprint();
  const Vector3d p(m.x, m.y, m.z);
  return std::any_of(world.boxes.begin(), world.boxes.end(), [&](const Box& box) {
    const double depth =
        f.radius > 0 ? BallDepth(world, p, f.radius, box) : RectangleDepth(m, f.half_length, f.half_width, box);
    return depth > kRounding;
  });
}

// Whether the straight line between two points meets the box (slabs). Between two control steps the centre leaves it by
// less than the footprint's inscribed radius.
bool Crosses(const World& world, const Vector3d& from, const Vector3d& to, const Box& box) {
  double first = 0, last = 1;
  for (int k = 0; k < world.dimension; ++k) {
    const double d = to[k] - from[k];
    if (d == 0) {
      if (from[k] <= box.min[k] || from[k] >= box.max[k]) return false;
      continue;
    }
    const double a = (box.min[k] - from[k]) / d, b = (box.max[k] - from[k]) / d;
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  return first < last;
}

bool WentThrough(const World& world, const Vector3d& from, const Vector3d& to) {
  return !world.Contains(world.bounds, to) || std::any_of(world.boxes.begin(), world.boxes.end(), [&](const Box& box) {
    return Crosses(world, from, to, box);
  });
}

// Actions of one episode: of one manner, drawn once.
class RandomActions {
 public:
  RandomActions(uint64_t seed, int64_t episode, int size)
      : random_(seed, RandomPurpose::kTest, static_cast<uint32_t>(episode)), manner_(random_.Below(3)), size_(size) {}

  const float* Next() {
    const bool held = manner_ == 1 && started_ && random_.Uniform() < 0.8;
    for (int i = 0; i < size_ && !held; ++i) {
      action_[i] = static_cast<float>(random_.Uniform(-1, 1));
      if (manner_ == 2) action_[i] = std::copysign(1.0f, action_[i]);
    }
    started_ = true;
    return action_.data();
  }

 private:
  RandomStream random_;
  uint32_t manner_;  // anew in every step, held for five steps in the mean, jumping between limits
  int size_;
  bool started_ = false;
  std::array<float, kMaxActionSize> action_{};
};

std::shared_ptr<const Scene> LoadScene(const std::string& kind) {
  std::string name = "car_maze", upper = kind;
  if (kind == "quadrotor" || kind == "quadruped") name = kind + "_maze";
  std::transform(upper.begin(), upper.end(), upper.begin(), [](unsigned char c) { return std::toupper(c); });
  const std::string path = std::string(CAIRN_SOURCE_DIR) + "/deploy/experiments/" + name + ".textproto";
  const Experiment experiment =
      LoadExperiment(path, {"vehicle.kind=" + upper, "environment.parameter_spread=0.2",
                            "environment.action_delay_steps=1", "environment.observation_noise=0.01"})
          .experiment;
  auto scene = std::make_shared<Scene>(experiment);
  const double spacing = 0.5 * experiment.planner.r_ball();
  scene->SetTable(testing::MakeGridLookup(scene->world(), scene->field(), spacing, experiment.planner.radius,
                                          experiment.planner.r_ball()));
  return scene;
}

bool IsFinite(const Motion& m) {
  const std::array<double, 8> values{m.x, m.y, m.z, m.yaw, m.vx, m.vy, m.vz, m.yaw_rate};
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

// One control step; what is wrong after it, if anything.
std::optional<std::string> StepAndLook(Environment& environment, const float* action, std::vector<float>& observation,
                                       Sums& sums) {
  const Motion before = environment.motion();
  const StepResult result = environment.Step(action);
  const Motion& after = environment.motion();
  const Vector3d from(before.x, before.y, before.z), to(after.x, after.y, after.z);
  environment.Observe(observation.data());
  ++sums.steps;
  if (environment.episode().outcome == Outcome::kDiverged) return "diverged";
  if (!IsFinite(after)) return "its motion is not finite";
  if (!std::isfinite(result.reward)) return "the reward is not finite";
  const auto bad = std::find_if(observation.begin(), observation.end(), [](float o) { return !std::isfinite(o); });
  if (bad != observation.end())
    return fmt::format("entry {} of its observation is {}", bad - observation.begin(), *bad);
  if (WentThrough(environment.scene().world(), from, to)) return "its centre went through an obstacle";
  const bool touches = environment.episode().outcome == Outcome::kCollision;
  if (!touches && InsideObstacle(environment.scene(), after)) return "it stands in an obstacle unnoticed";
  sums.way += (to - from).norm();
  sums.top_speed = std::max(sums.top_speed, std::hypot(after.vx, after.vy, after.vz));
  return std::nullopt;
}

void Count(Outcome outcome, Sums& sums) {
  ++sums.episodes;
  sums.goals += outcome == Outcome::kGoal ? 1 : 0;
  sums.collisions += outcome == Outcome::kCollision ? 1 : 0;
  sums.timeouts += outcome == Outcome::kTimeout ? 1 : 0;
}

int Drive(const Options& options) {
  const auto scene = LoadScene(options.kind);
  Environment environment(scene);
  std::vector<float> observation(static_cast<size_t>(ObservationSize(scene->experiment())));
  Sums sums;
  long memory = 0;
  while (sums.steps < options.steps) {
    environment.ResetTraining(0, static_cast<int>(sums.episodes));
    RandomActions actions(options.seed, sums.episodes, scene->experiment().vehicle.action_size());
    while (sums.steps < options.steps && environment.episode().outcome == Outcome::kRunning) {
      const auto wrong = StepAndLook(environment, actions.Next(), observation, sums);
      if (wrong) {
        const Motion& m = environment.motion();
        fmt::print("{}: {} after {} steps, episode {}, step {}, at {} {} {} yaw {}\n", options.kind, *wrong, sums.steps,
                   sums.episodes, environment.episode().steps, m.x, m.y, m.z, m.yaw);
        return 1;
      }
      if (sums.steps == options.steps / 10) memory = ResidentKb();
    }
    Count(environment.episode().outcome, sums);
  }
  const long growth = ResidentKb() - memory;
  fmt::print(
      "{} steps in {} episodes, {:.0f} m, up to {:.2f} m/s: {} collisions, {} goals, {} time-outs; {} kB, {:+} kB "
      "after the first tenth\n",
      sums.steps, sums.episodes, sums.way, sums.top_speed, sums.collisions, sums.goals, sums.timeouts, ResidentKb(),
      growth);
  return growth > kMemoryGrowth ? 1 : 0;
}

Options Parse(int argc, char** argv) {
  Options options;
  if (argc < 2 || argc % 2 != 0) ThrowUsageError("usage: cairn-random-commands KIND [--steps N] [--seed S]");
  options.kind = argv[1];
  for (int i = 2; i < argc; i += 2) {
    const std::string name = argv[i];
    const auto value = static_cast<int64_t>(std::strtod(argv[i + 1], nullptr));  // 1e7 is a number of steps too
    if (name == "--steps" && value >= 10) {
      options.steps = value;
    } else if (name == "--seed" && value >= 0) {
      options.seed = static_cast<uint64_t>(value);
    } else {
      ThrowUsageError("{} {}: no such option, or steps below 10", name, argv[i + 1]);
    }
  }
  return options;
}

}  // namespace
}  // namespace cairn::actors

int main(int argc, char** argv) {
  try {
    return cairn::actors::Drive(cairn::actors::Parse(argc, argv));
  } catch (const std::exception& error) {
    fmt::print(stderr, "cairn-random-commands: {}\n", error.what());
    return 2;
  }
}
