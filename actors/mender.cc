#include "actors/mender.h"

#include <algorithm>

#include "common/roadmap/world_goal.h"

namespace cairn::actors {

Mender::Mender(const PlannerConfig& config)
    : active_(config.repair != PlannerConfig::Repair::kNone),
      kept_(config.repair_kept),
      radius_(config.repair_mark_radius),
      lifetime_(config.repair_lifetime) {}

void Mender::Begin(uint64_t world_seed) {
  if (!kept_) worlds_.clear();
  world_seed_ = world_seed;
  worlds_.try_emplace(world_seed, NoMarks());
  begun_ = now_;
}

bool Mender::Report(const Findings& findings, double elapsed) {
  now_ = begun_ + elapsed;
  Marks& marks = worlds_.at(world_seed_);
  bool news = marks.Forget(now_);
  for (const Vector3d& p : findings.freed) news = marks.Remove(p) || news;
  for (const Vector3d& p : findings.found) news = marks.Add(p, now_) || news;
  return news;
}

std::vector<float> Mender::marks() const {
  std::vector<float> flat;
  const auto known = worlds_.find(world_seed_);
  if (known == worlds_.end()) return flat;
  const std::vector<Vector3d> places = known->second.places();
  const size_t count = std::min(places.size(), WorldGoal::kMaxMarks);
  for (size_t i = places.size() - count; i < places.size(); ++i) {
    for (int k = 0; k < 3; ++k) flat.push_back(static_cast<float>(places[i][k]));
  }
  return flat;
}

void Mender::Write(BlobWriter& blob) const {
  blob.Put(world_seed_), blob.Put(begun_), blob.Put(now_);
  blob.Put(static_cast<uint64_t>(worlds_.size()));
  for (const auto& [seed, marks] : worlds_) {
    blob.Put(seed);
    marks.Write(blob);
  }
}

void Mender::Read(BlobReader& blob) {
  worlds_.clear();
  blob.Get(world_seed_), blob.Get(begun_), blob.Get(now_);
  uint64_t count = 0;
  blob.Get(count);
  for (uint64_t i = 0; i < count; ++i) {
    uint64_t seed = 0;
    blob.Get(seed);
    worlds_.try_emplace(seed, NoMarks()).first->second.Read(blob);
  }
}

}  // namespace cairn::actors
