#include "tests/benchmarks/episode_tapes.h"

#include "actors/command.h"
#include "actors/controllers/pure_pursuit.h"
#include "actors/environment.h"
#include "actors/episode_streams.h"
#include "tests/testing/grid_roadmap.h"

namespace cairn::actors {

std::shared_ptr<const Scene> MakeGridScene(const Experiment& experiment, double radius) {
  auto scene = std::make_shared<Scene>(experiment);
  scene->SetTable(testing::MakeGridLookup(scene->world(), scene->field(), 0.025, radius, experiment.planner.r_ball()));
  return scene;
}

std::vector<Tape> RecordTapes(const std::shared_ptr<const Scene>& scene, int episodes) {
  const Experiment& experiment = scene->experiment();
  const auto referee = MakeGridScene(experiment, PurePursuit::Planner(experiment).radius);
  const int size = experiment.vehicle.action_size();
  PurePursuit controller(referee);
  RandomStream random(1, RandomPurpose::kTest);
  Environment environment(scene);
  const Environment* one[] = {&environment};
  std::vector<Tape> tapes;
  for (int episode = 0; episode < episodes; ++episode) {
    Tape tape{episode, {}};
    environment.ResetTraining(0, episode);
    do {
      float action[kMaxActionSize];
      controller.Act(one, action);
      if (random.Uniform() < 0.1) {
        for (int i = 0; i < size; ++i) action[i] = static_cast<float>(random.Uniform(-1, 1));
      }
      tape.actions.insert(tape.actions.end(), action, action + size);
    } while (environment.Step(tape.actions.data() + tape.actions.size() - size).end == SegmentEnd::kNone);
    tapes.push_back(std::move(tape));
  }
  return tapes;
}

PhysicsAndContact::PhysicsAndContact(const Scene& scene)
    : scene_(scene),
      vehicle_(MakeVehicle(scene.experiment().vehicle, scene.experiment().environment)),
      contact_(scene),
      disturbance_(scene.experiment().environment, scene.experiment().vehicle),
      speed_error_(scene.experiment().vehicle) {}

int64_t PhysicsAndContact::Play(const Tape& tape) {
  EpisodeResult name;
  name.episode = tape.episode;
  const uint64_t seed = scene_.experiment().seed;
  const VehicleConfig& config = scene_.experiment().vehicle;
  RandomStream parameters = EpisodeStream(seed, name, NoiseUse::kParameters);
  disturbance_.Reset(EpisodeStream(seed, name, NoiseUse::kDisturbance));
  vehicle_->Reset(scene_.TrainingStart(0, tape.episode), parameters);
  int64_t physics_steps = 0;
  for (size_t i = 0; i < tape.actions.size(); i += static_cast<size_t>(config.action_size())) {
    const VehicleCommand command = ToCommand(config, &tape.actions[i]);
    if (!PlayControlStep(command, physics_steps)) break;
    speed_error_.Add(vehicle_->motion(), command);
  }
  return physics_steps;
}

bool PhysicsAndContact::PlayControlStep(const VehicleCommand& command, int64_t& physics_steps) {
  const World& world = scene_.world();
  for (int i = 0; i < scene_.control_physics_steps(); ++i) {
    if (disturbance_.Advance(physics_steps) || i == 0) vehicle_->Command(disturbance_.Apply(command));
    vehicle_->Step();
    ++physics_steps;
    const Motion state = vehicle_->motion();
    if (contact_.Touches(state, contact_.CenterDistance(state)) || vehicle_->fallen()) return false;
    if (world.Contains(world.goal, Vector3d(state.x, state.y, state.z))) return false;
  }
  return true;
}

}  // namespace cairn::actors
