// Writes one sound message of each type as the fuzzers' first input: seeds DIRECTORY.
#include <filesystem>
#include <fstream>

#include "common/bus/codec.h"
#include "learner/checkpoint/checkpoint_file.h"
#include "planner/roadmap_file.h"
#include "tests/fuzz/map_seeds.h"

namespace cairn {
namespace {

void Write(const std::filesystem::path& directory, const std::string& target, const char* bytes, size_t size) {
  std::filesystem::create_directories(directory / target);
  std::ofstream(directory / target / "sound", std::ios::binary).write(bytes, static_cast<std::streamsize>(size));
}

template <typename Message>
void Write(const std::filesystem::path& directory, const std::string& target, const Message& message) {
  const Bytes bytes = Encode(message);
  Write(directory, target, reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

Experience MakeExperience() {
  Experience m;
  m.session = 1;
  m.sequence = 1;
  m.observation_size = 3;
  m.action_size = 2;
  Segment s;
  s.observations.assign(3 * 3, 0.5f);
  s.actions.assign(2 * 2, 0.5f);
  s.rewards.assign(2, 1.0f);
  m.segments = {s, s};
  m.episodes.resize(2);
  m.states = {{1, 2, 3, 0, {1, 2, 3}}};
  return m;
}

Control MakeControl() {
  Control m;
  m.rounds = {{3, 30, 0, 7, true}, {4, 40, 2, 8, false}};
  m.actors.resize(2);
  m.actors[1].gaps = {{2, 3}, {5, 5}};
  return m;
}

void WriteAll(const std::filesystem::path& d) {
  Write(d, "Echo", Echo{5, 16});
  Write(d, "Hello", Hello{.session = 1, .git_revision = "abc", .isa = "cpx"});
  Write(d, "Welcome",
        Welcome{.vehicle = {1}, .next_episode = {2}, .steps_done = {3}, .state_bytes = {4}, .reason = "x"});
  Write(d, "AssignedState", AssignedState{1, 2, 3, {1, 2, 3, 0, {1, 2, 3}}});
  Write(d, "ActorStatus", ActorStatus{.session = 1});
  Write(d, "Experience", MakeExperience());
  Write(d, "Control", MakeControl());
  Write(d, "PolicyChunk", PolicyChunk{.total = 4, .offset = 1, .parameters = {1, 2, 3}});
  Write(d, "TableRequest",
        TableRequest{.hash = 1, .num_chunks = 2, .goal = WorldGoal(1, {Vector3d(1, 2, 3), Vector3d(4, 5, 6)})});
  Write(d, "TableInfo", TableInfo{.num_vertices = 3, .goal = WorldGoal(1, {Vector3d(1, 2, 3), Vector3d(4, 5, 6)})});
  Write(d, "TableChunk", TableChunk{.hash = 1, .total_bytes = 3, .chunk_bytes = 3, .data = {1, 2, 3}});
  Write(d, "LearnerTelemetry", LearnerTelemetry{.phase = "training"});
  Write(d, "ActorTelemetry", ActorTelemetry{.actor_id = 1});
  Write(d, "PlannerTelemetry", PlannerTelemetry{.num_vertices = 3});
  Write(d, "RobotState", RobotState{.utime = 1, .ranges = {1, 2, 3}});
  Write(d, "RobotCommand", RobotCommand{.command = {1, 2}, .note = "x"});
  for (const auto& [target, bytes] : MapSeeds()) Write(d, target, bytes.data(), bytes.size());
  planner::SavedRoadmap saved{PlannerConfig::Kind::kRrt, 0.03, 1, 2, {}};
  saved.roadmap.positions = {0, 0, 1, 0, 1, 1};
  saved.roadmap.offsets = {0, 1, 3, 4};
  saved.roadmap.neighbors = {1, 0, 2, 1};
  saved.roadmap.lengths = {1, 1, 1, 1};
  const std::string roadmap = planner::EncodeRoadmap(saved);
  Write(d, "roadmap", roadmap.data(), roadmap.size());
  Write(d, "roadmap-body", roadmap.data() + 20, roadmap.size() - 24);
  learner::RunState state;
  state.algorithm = {{"policy", {1, 2, 3, 4}}};
  state.coordinator.vehicles.resize(2);
  state.coordinator.sessions.resize(1);
  const std::string checkpoint = learner::EncodeCheckpoint(state);
  Write(d, "checkpoint", checkpoint.data(), checkpoint.size());
  Write(d, "checkpoint-body", checkpoint.data() + 20, checkpoint.size() - 24);
}

}  // namespace
}  // namespace cairn

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  cairn::WriteAll(argv[1]);
  return 0;
}
