#include "deploy/launcher/value_maps.h"

#include <fmt/core.h>

#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "actors/contact_test.h"
#include "actors/observation.h"
#include "actors/rewards/reward.h"
#include "common/core/check.h"
#include "common/core/files.h"
#include "common/nn/policy.h"
#include "deploy/launcher/local_tables.h"
#include "learner/algorithms/saved_values.h"
#include "learner/checkpoint/checkpointer.h"
#include "planner/picture.h"
#include "planner/value_map.h"

namespace cairn::deploy {
namespace {

// Cells along the longer side: an observation is cheap, an episode is not.
constexpr int kQAcross = 120, kScoreAcross = 60;
constexpr int kHeadings = 8;

// Networks of one policy and what to call them.
struct SavedNetworks {
  std::string name;
  std::vector<learner::StateArray> arrays;
};

bool KnowsBest(const learner::RunState& state) {
  return state.evaluation.best && state.candidates.contains(state.evaluation.best->version);
}

SavedNetworks ChooseNetworks(const RunDirectory& run, const std::string& wanted) {
  learner::RunState state = learner::ReadNewestCheckpoint(run.path() + "/checkpoints");
  if (wanted == "last") return {fmt::format("last networks, {} env steps", state.env_steps), state.algorithm};
  if (KnowsBest(state)) {
    const auto& best = *state.evaluation.best;
    return {fmt::format("best networks, {} env steps", best.env_steps), state.candidates.at(best.version)};
  }
  return {fmt::format("last networks, {} env steps (checkpoints keep no critics of the best)", state.env_steps),
          state.algorithm};
}

// The field answers for the middle of obstacles, the contact test for their edges.
bool IsFree(const actors::ContactTest& contact, const actors::Motion& motion) {
  const double distance = contact.CenterDistance(motion);
  return distance > 0 && !contact.Touches(motion, distance);
}

// Asks the critics place by place.
class Surveyor {
 public:
  Surveyor(const actors::Scene& scene, const PolicyShape& shape, const SavedNetworks& networks)
      : scene_(scene),
        builder_(scene),
        contact_(scene),
        reward_(actors::MakeReward(scene.experiment())),
        values_(shape, networks.arrays),
        headings_(scene.experiment().vehicle.turns() ? kHeadings : 1),
        observations_(static_cast<size_t>(kHeadings) * static_cast<size_t>(builder_.size())) {}

  /// Mean over the free headings at rest; NaN where there is none.
  float ValueAt(const Vector3d& p) {
    const float d_min = reward_->Distance(scene_, p);
    int n = 0;
    for (int i = 0; i < headings_; ++i) {
      const double yaw = 2 * std::numbers::pi * i / headings_;
      const actors::Motion motion{p.x(), p.y(), p.z(), yaw};
      if (!IsFree(contact_, motion)) continue;
      builder_.Build(motion, d_min, observations_.data() + static_cast<size_t>(n++) * builder_.size());
    }
    std::array<float, kHeadings> q{};
    values_.Evaluate(observations_.data(), n, q.data());
    float sum = 0;
    for (int i = 0; i < n; ++i) sum += q[i];
    return sum / static_cast<float>(n);  // 0 / 0 = NaN
  }

 private:
  const actors::Scene& scene_;
  actors::ObservationBuilder builder_;
  actors::ContactTest contact_;
  std::unique_ptr<actors::Reward> reward_;
  learner::SavedValues values_;
  int headings_;
  std::vector<float> observations_;
};

// What is mapped: the world, or a slice of it.
struct Section {
  World plane;
  double height = 0;  // [m]
  std::string where;  // of titles
};

Section MakeSection(const World& world, std::optional<double> height) {
  if (world.dimension == 2) {
    if (height) ThrowUsageError("--height {}: the world is plane", *height);
    return {world, 0, ""};
  }
  const double low = world.bounds.min.z(), high = world.bounds.max.z();
  const double z = height.value_or(0.5 * (low + high));
  if (!(low < z && z < high)) ThrowUsageError("--height {}: the world reaches from {} to {} m", z, low, high);
  return {planner::Slice(world, z), z, fmt::format(" at z = {:.3g} m", z)};
}

// Calls visit(place, value) for the cells outside the goal: no episode begins in it.
template <typename Visit>
void ForEachCell(const Section& section, planner::ValueMap* map, const Visit& visit) {
  float* value = map->values.data();
  for (int row = 0; row < map->rows; ++row) {
    for (int column = 0; column < map->columns; ++column, ++value) {
      Vector3d p = planner::CellCenter(section.plane, *map, row, column);
      p.z() = section.height;
      if (!section.plane.Contains(section.plane.goal, p)) visit(p, value);
    }
  }
}

void Write(const Section& section, const planner::ValueMap& map, const std::string& title, const std::string& subtitle,
           const std::string& file) {
  planner::PictureOptions picture;
  picture.title = title + section.where;
  picture.subtitle = subtitle;
  picture.values = &map;
  WriteFileAtomically(file, planner::DrawScene(section.plane, nullptr, nullptr, {}, picture));
}

// Along the roadmap, as far as the nearer look-ahead point; 0 for a vehicle that keeps its yaw.
double HeadingFrom(const actors::Scene& scene, const Vector3d& p) {
  const ObservationConfig& config = scene.experiment().observation;
  const int entry = scene.lookup().EntryVertex(p, scene.known_field(), config.look_ahead_clearance);
  if (entry < 0 || !scene.experiment().vehicle.turns()) return 0;
  const Vector3d gap = scene.lookup().PointAlong(p, entry, config.look_ahead_near) - p;
  return std::atan2(gap.y(), gap.x());
}

}  // namespace

void WriteQMap(const RunDirectory& run, const actors::Scene& scene, const std::string& policy,
               std::optional<double> height, const std::string& file) {
  const Experiment& experiment = scene.experiment();
  const Section section = MakeSection(scene.world(), height);
  const SavedNetworks networks = ChooseNetworks(run, policy);
  const PolicyShape shape = LoadPolicy(run.policy_file("last")).shape;
  if (shape.observation_size != ObservationSize(experiment)) {
    ThrowError("{}: {} observations, the directory's experiment has {}", run.policy_file("last"),
               shape.observation_size, ObservationSize(experiment));
  }
  Surveyor surveyor(scene, shape, networks);
  planner::ValueMap map = planner::MakeValueMap(section.plane, kQAcross);
  map.label = "Q(s, π(s))";
  ForEachCell(section, &map, [&](const Vector3d& p, float* value) { *value = surveyor.ValueAt(p); });
  Write(section, map, experiment.name + ": what the critics expect",
        networks.name + (experiment.vehicle.turns() ? ", at rest, mean of headings" : ", at rest"), file);
}

void WriteScoreMap(const std::shared_ptr<const actors::Scene>& scene, actors::Controller& controller,
                   actors::EvaluationOptions evaluation, const std::string& driver, std::optional<double> height,
                   const std::string& file) {
  const Experiment& experiment = scene->experiment();
  const Section section = MakeSection(scene->world(), height);
  planner::ValueMap map = planner::MakeValueMap(section.plane, kScoreAcross);
  const double gamma = experiment.learner.gamma;
  map.label = fmt::format("{:.4g}^steps where the goal is reached, else 0", gamma);
  const actors::ContactTest contact(*scene);
  std::vector<float*> cells;
  ForEachCell(section, &map, [&](const Vector3d& p, float* value) {
    const actors::Motion motion{p.x(), p.y(), p.z(), HeadingFrom(*scene, p)};
    if (!IsFree(contact, motion)) return;
    evaluation.poses.push_back(motion.pose());
    cells.push_back(value);
  });
  const int starts = static_cast<int>(cells.size());
  const std::vector<EpisodeResult> results =
      actors::RunEpisodes(MakeLocalCourse(scene), StartSet::kTest, actors::AllStarts(starts), controller, evaluation);
  int successes = 0;
  for (size_t i = 0; i < results.size(); ++i) {
    const bool success = results[i].outcome == Outcome::kGoal;
    successes += success ? 1 : 0;
    *cells[i] = success ? static_cast<float>(std::pow(gamma, results[i].steps)) : 0;
  }
  Write(section, map, experiment.name + ": discounted success",
        fmt::format("{}, {} of {} places", driver, successes, starts), file);
}

}  // namespace cairn::deploy
