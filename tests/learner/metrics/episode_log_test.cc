#include "learner/metrics/episode_log.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace cairn::learner {
namespace {

std::string ReadText(const std::string& path) {
  std::ifstream file(path);
  return std::string(std::istreambuf_iterator<char>(file), {});
}

EpisodeResult GoalEpisode() {
  EpisodeResult episode;
  episode.vehicle = 7;
  episode.episode = 3;
  episode.steps = 42;
  episode.outcome = Outcome::kGoal;
  episode.policy_version = 1234;
  episode.episode_return = 15.5f;
  episode.duration = 4.15f;
  episode.path_length = 2.25f;
  episode.shortest_length = 2.0f;
  episode.min_clearance = 0.0125f;
  episode.mean_jerk = 0.5f;
  episode.filtered_steps = 6;
  return episode;
}

constexpr char kHeader[] =
    "episode_id,vehicle,episode,steps,return,outcome,policy_version,duration_s,path_length_m,shortest_length_m,"
    "min_clearance_m,mean_jerk_m_s3,filtered_steps,env_steps,wall_s\n";

TEST(EpisodeLogTest, WritesALineAnEpisode) {
  const std::string path = testing::TempDir() + "episode_log_lines.csv";
  {
    EpisodeLog log(path);
    log.Add(GoalEpisode(), 5000, 12.3456);
    EpisodeResult collision = GoalEpisode();
    collision.outcome = Outcome::kCollision;
    collision.episode = 4;
    log.Add(collision, 5050, 12.5);
  }
  EXPECT_EQ(ReadText(path), std::string(kHeader) +
                                "0,7,3,42,15.5,goal,1234,4.15,2.25,2,0.0125,0.5,6,5000,12.346\n"
                                "1,7,4,42,15.5,collision,1234,4.15,2.25,2,0.0125,0.5,6,5050,12.500\n");
  std::filesystem::remove(path);
}

TEST(EpisodeLogTest, GoesOnWhereItEnded) {
  const std::string path = testing::TempDir() + "episode_log_append.csv";
  { EpisodeLog(path).Add(GoalEpisode(), 1, 1.0); }
  { EpisodeLog(path, static_cast<int64_t>(std::filesystem::file_size(path))).Add(GoalEpisode(), 2, 2.0); }
  EXPECT_EQ(ReadText(path), std::string(kHeader) +
                                "0,7,3,42,15.5,goal,1234,4.15,2.25,2,0.0125,0.5,6,1,1.000\n"
                                "1,7,3,42,15.5,goal,1234,4.15,2.25,2,0.0125,0.5,6,2,2.000\n");
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace cairn::learner
