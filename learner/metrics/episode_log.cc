#include "learner/metrics/episode_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>

namespace cairn::learner {
namespace {

constexpr char kHeader[] =
    "episode_id,vehicle,episode,steps,return,outcome,policy_version,duration_s,path_length_m,shortest_length_m,"
    "min_clearance_m,mean_jerk_m_s3,env_steps,wall_s\n";

// Lines that a file already has, without its header.
int64_t CountEpisodes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const auto lines = std::count(std::istreambuf_iterator<char>(file), {}, '\n');
  return std::max<int64_t>(0, lines - 1);
}

}  // namespace

EpisodeLog::EpisodeLog(const std::string& path, bool append)
    : next_id_(append ? CountEpisodes(path) : 0), file_(path, append) {
  if (file_.size() > 0) return;
  file_.Append(kHeader);
  file_.Flush();
}

void EpisodeLog::Add(const EpisodeResult& episode, int64_t env_steps, double wall_s) {
  file_.Append(fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{:.3f}\n", next_id_++, episode.vehicle,
                           episode.episode, episode.steps, episode.episode_return, OutcomeName(episode.outcome),
                           episode.policy_version, episode.duration, episode.path_length, episode.shortest_length,
                           episode.min_clearance, episode.mean_jerk, env_steps, wall_s));
}

}  // namespace cairn::learner
