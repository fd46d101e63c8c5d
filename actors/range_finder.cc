#include "actors/range_finder.h"

#include <algorithm>

namespace cairn::actors {
namespace {

constexpr uint64_t kDrawsPerRay = 4;  // of 32 bits: a uniform and a normal number take two each

}  // namespace

RangeFinder::RangeFinder(const Scene& scene, const Persons* persons, const RandomStream& random, uint64_t look)
    : scene_(scene),
      persons_(persons),
      noise_(scene.experiment().observation.range_noise),
      dropout_(scene.experiment().observation.range_dropout),
      random_(random) {
  if (noise_ > 0 || dropout_ > 0) random_.SetPosition(look * kMaxRays * kDrawsPerRay);
}

RangeFinder::RangeFinder(const Scene& scene)
    : scene_(scene), persons_(nullptr), noise_(0), dropout_(0), random_(0, RandomPurpose::kRanges) {}

RangeFinder::RangeFinder(const Scene& scene, const MeasuredScan& scan) : RangeFinder(scene) { scan_ = &scan; }

double RangeFinder::TrueRange(const Vector3d& p, const Vector3d& direction, double max_range) const {
  if (scan_ != nullptr) return scan_->Range(p, direction, max_range);
  const double range = scene_.world().dimension == 2
                           ? scene_.obstacles().CastRay(p.x(), p.y(), direction.x(), direction.y(), max_range)
                           : scene_.space_obstacles().CastRay(p, direction, max_range);
  return persons_ == nullptr || persons_->empty() ? range : persons_->CastRay(p, direction, range);
}

double RangeFinder::Range(const Vector3d& p, const Vector3d& direction, double max_range) {
  const double range = TrueRange(p, direction, max_range);
  if (noise_ == 0 && dropout_ == 0) return range;
  const bool lost = random_.Uniform() < dropout_;
  const double noisy = range + noise_ * random_.Normal();
  return lost || range >= max_range ? max_range : std::clamp(noisy, 0.0, max_range);
}

}  // namespace cairn::actors
