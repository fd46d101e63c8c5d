#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "common/bus/messages.h"

namespace cairn::actors {

/// Policies as they arrive in chunks: complete ones by version, of the newest learner incarnation only. Bounded: the
/// oldest version that is not pinned goes first.
class PolicyStore {
 public:
  explicit PolicyStore(int num_parameters) : num_parameters_(num_parameters) {}

  /// Takes a chunk; ignores foreign incarnations, wrong sizes and checksums. Returns true when it completed a policy.
  bool Add(const PolicyChunk& chunk);

  /// A new learner incarnation forgets everything before.
  void SetIncarnation(int64_t incarnation);

  /// Keep this version until another is pinned.
  void Pin(int64_t version) { pinned_ = version; }

  /// Parameters of a version; nullptr when it is not complete.
  const std::vector<float>* Find(int64_t version) const;
  /// Newest complete version; −1: none.
  int64_t newest() const { return complete_.empty() ? -1 : complete_.rbegin()->first; }

 private:
  struct Partial {
    std::vector<float> parameters;
    std::vector<bool> have;
    int missing = 0;
  };
  static constexpr size_t kMaxVersions = 6;

  bool Complete(int64_t version, std::vector<float> parameters, uint32_t crc);

  int num_parameters_;
  int64_t incarnation_ = 0;
  int64_t pinned_ = -1;
  std::map<int64_t, std::vector<float>> complete_;
  std::map<int64_t, Partial> partial_;
};

}  // namespace cairn::actors
