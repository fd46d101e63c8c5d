#include "learner/metrics/episode_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "common/core/check.h"

namespace cairn::learner {
namespace {

constexpr char kHeader[] =
    "episode_id,vehicle,episode,steps,return,outcome,policy_version,duration_s,path_length_m,shortest_length_m,"
    "min_clearance_m,mean_jerk_m_s3,filtered_steps,env_steps,wall_s\n";

// Lines that a file already has, without its header.
int64_t CountEpisodes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const auto lines = std::count(std::istreambuf_iterator<char>(file), {}, '\n');
  return std::max<int64_t>(0, lines - 1);
}

// Cuts the file back, so that a resumed run writes its episodes after the checkpoint only once.
bool CutBack(const std::string& path, int64_t keep_bytes) {
  if (keep_bytes < 0) return false;
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  if (!error && size > static_cast<uintmax_t>(keep_bytes)) {
    std::filesystem::resize_file(path, static_cast<uintmax_t>(keep_bytes), error);
    if (error) ThrowError("{}: cannot cut back to {} bytes: {}", path, keep_bytes, error.message());
  }
  return true;
}

}  // namespace

EpisodeLog::EpisodeLog(const std::string& path, int64_t keep_bytes)
    : next_id_(CutBack(path, keep_bytes) ? CountEpisodes(path) : 0), file_(path, keep_bytes >= 0) {
  if (file_.size() > 0) return;
  file_.Append(kHeader);
  file_.Flush();
}

void EpisodeLog::Add(const EpisodeResult& episode, int64_t env_steps, double wall_s) {
  file_.Append(fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{:.3f}\n", next_id_++, episode.vehicle,
                           episode.episode, episode.steps, episode.episode_return, OutcomeName(episode.outcome),
                           episode.policy_version, episode.duration, episode.path_length, episode.shortest_length,
                           episode.min_clearance, episode.mean_jerk, episode.filtered_steps, env_steps, wall_s));
}

}  // namespace cairn::learner
