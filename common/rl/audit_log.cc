#include "common/rl/audit_log.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "common/core/check.h"
#include "common/core/hash.h"

namespace cairn {

AuditLog::AuditLog(const std::string& name) {
  const char* directory = std::getenv("CAIRN_AUDIT_DIR");
  if (directory == nullptr || *directory == '\0') return;
  const std::filesystem::path path = std::filesystem::path(directory) / (name + ".audit");
  file_.reset(std::fopen(path.c_str(), "a"));
  if (!file_) ThrowError("audit file {}: {}", path.string(), std::strerror(errno));
}

void AuditLog::Add(const Segment& segment, int observation_size, int action_size) {
  if (!file_) return;
  const auto observation = static_cast<size_t>(observation_size);
  const auto action = static_cast<size_t>(action_size);
  for (size_t t = 0; t < segment.rewards.size(); ++t) {
    uint64_t hash = ContentHash(segment.observations.data() + t * observation, 2 * observation * sizeof(float));
    hash = ContentHash(segment.actions.data() + t * action, action * sizeof(float), hash);
    hash = ContentHash(&segment.rewards[t], sizeof(float), hash);
    std::fprintf(file_.get(), "%d %d %d %016llx\n", segment.vehicle, segment.episode,
                 segment.first_step + static_cast<int>(t), static_cast<unsigned long long>(hash));
  }
}

void AuditLog::Flush() {
  if (file_) std::fflush(file_.get());
}

}  // namespace cairn
