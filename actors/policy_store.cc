#include "actors/policy_store.h"

#include <algorithm>

#include "common/core/hash.h"

namespace cairn::actors {
namespace {

template <typename Map>
void DropOldest(Map* map, size_t max_size, int64_t pinned) {
  for (auto it = map->begin(); it != map->end() && map->size() > max_size;) {
    it = it->first == pinned ? std::next(it) : map->erase(it);
  }
}

}  // namespace

void PolicyStore::SetIncarnation(int64_t incarnation) {
  if (incarnation == incarnation_) return;
  incarnation_ = incarnation;
  complete_.clear();
  partial_.clear();
}

bool PolicyStore::Add(const PolicyChunk& chunk) {
  if (chunk.incarnation != incarnation_ || chunk.total != num_parameters_ || complete_.contains(chunk.version)) {
    return false;
  }
  if (chunk.offset == 0 && static_cast<int>(chunk.parameters.size()) == num_parameters_) {
    return Complete(chunk.version, chunk.parameters, chunk.parameters_crc);
  }
  Partial& partial = partial_[chunk.version];
  if (partial.parameters.empty()) {
    partial.parameters.resize(static_cast<size_t>(num_parameters_));
    partial.have.resize(static_cast<size_t>(num_parameters_));
    partial.missing = num_parameters_;
  }
  for (size_t i = 0; i < chunk.parameters.size(); ++i) {
    const size_t at = static_cast<size_t>(chunk.offset) + i;
    if (!partial.have[at]) --partial.missing;
    partial.have[at] = true;
    partial.parameters[at] = chunk.parameters[i];
  }
  if (partial.missing > 0) {
    DropOldest(&partial_, kMaxVersions, chunk.version);
    return false;
  }
  std::vector<float> parameters = std::move(partial.parameters);
  partial_.erase(chunk.version);
  return Complete(chunk.version, std::move(parameters), chunk.parameters_crc);
}

bool PolicyStore::Complete(int64_t version, std::vector<float> parameters, uint32_t crc) {
  if (Crc32c(parameters.data(), parameters.size() * sizeof(float)) != crc) return false;
  partial_.erase(version);
  complete_[version] = std::move(parameters);
  DropOldest(&complete_, kMaxVersions, pinned_);
  return true;
}

const std::vector<float>* PolicyStore::Find(int64_t version) const {
  const auto it = complete_.find(version);
  return it == complete_.end() ? nullptr : &it->second;
}

}  // namespace cairn::actors
