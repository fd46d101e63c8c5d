#include "actors/marks.h"

#include <algorithm>

namespace cairn::actors {
namespace {

// A mark that is confirmed for so long stands still: a passer-by of half a robot length a second is out of a mark's
// radius sooner.
constexpr double kStands = 1.5;  // [s]
// After so many lifetimes also that there was a mark is forgotten.
constexpr double kMemory = 16;

}  // namespace

// The nearest one within the radius.
Marks::Mark* Marks::Find(const Vector3d& p) {
  Mark* nearest = nullptr;
  double least = radius_;
  for (Mark& mark : marks_) {
    const double distance = (mark.p - p).norm();
    if (distance >= least) continue;
    nearest = &mark;
    least = distance;
  }
  return nearest;
}

bool Marks::Add(const Vector3d& p, double time) {
  Mark* mark = Find(p);
  if (mark == nullptr) {
    marks_.push_back({p, time, time, lifetime_, true, false});
    return true;
  }
  const bool news = !mark->in_force;
  if (news) mark->since = time;
  mark->found_again = news || mark->found_again;
  if (mark->found_again && time - mark->since >= kStands) {
    mark->lifetime *= 2;
    mark->found_again = false;
  }
  mark->in_force = true;
  mark->seen = time;
  return news;
}

bool Marks::Remove(const Vector3d& p) {
  Mark* mark = Find(p);
  if (mark == nullptr) return false;
  const bool news = mark->in_force;
  marks_.erase(marks_.begin() + (mark - marks_.data()));
  return news;
}

bool Marks::Forget(double time) {
  bool news = false;
  for (Mark& mark : marks_) {
    if (!mark.in_force || time - mark.seen <= mark.lifetime) continue;
    mark.in_force = false;
    news = true;
  }
  std::erase_if(marks_, [&](const Mark& mark) { return time - mark.seen > kMemory * mark.lifetime; });
  return news;
}

std::vector<Vector3d> Marks::places() const {
  std::vector<Vector3d> places;
  for (const Mark& mark : marks_) {
    if (mark.in_force) places.push_back(mark.p);
  }
  return places;
}

void Marks::Write(BlobWriter& blob) const {
  blob.Put(static_cast<uint64_t>(marks_.size()));
  for (const Mark& mark : marks_) {
    blob.Put(mark.p.x()), blob.Put(mark.p.y()), blob.Put(mark.p.z());
    blob.Put(mark.since), blob.Put(mark.seen), blob.Put(mark.lifetime);
    blob.Put(mark.in_force), blob.Put(mark.found_again);
  }
}

void Marks::Read(BlobReader& blob) {
  uint64_t count = 0;
  blob.Get(count);
  marks_.clear();
  for (uint64_t i = 0; i < count; ++i) {
    Mark mark;
    blob.Get(mark.p.x()), blob.Get(mark.p.y()), blob.Get(mark.p.z());
    blob.Get(mark.since), blob.Get(mark.seen), blob.Get(mark.lifetime);
    blob.Get(mark.in_force), blob.Get(mark.found_again);
    marks_.push_back(mark);
  }
}

}  // namespace cairn::actors
