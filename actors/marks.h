#pragma once

#include <vector>

#include "actors/blob.h"
#include "common/world/world.h"

namespace cairn::actors {

/// Obstacles that vehicles have found in a world and the map does not have. A mark is forgotten when nobody has seen it
/// for its lifetime or when somebody has seen through it: a passer-by closes no corridor for good. A place that is
/// found blocked again after its mark was forgotten unseen, and stays so while it is seen, is believed twice as long as
/// the last time, so that nobody runs back and forth before a shut door for ever. What was seen to be free begins anew.
/// One thread.
class Marks {
 public:
  /// `radius` [m] > 0: marks nearer to each other than this are one. `lifetime` [s] > 0: of a first mark.
  Marks(double radius, double lifetime) : radius_(radius), lifetime_(lifetime) {}

  /// Something stands at p. True when that is news, also if only because it had been forgotten.
  bool Add(const Vector3d& p, double time);
  /// Nothing stands at p, the place of a mark. True when that is news.
  bool Remove(const Vector3d& p);
  /// Forgets what was not seen for too long. True when there was something. `time` never goes back.
  bool Forget(double time);

  /// Places of the marks in force, oldest first.
  std::vector<Vector3d> places() const;
  bool empty() const { return marks_.empty(); }

  void Write(BlobWriter& blob) const;
  void Read(BlobReader& blob);

 private:
  struct Mark {
    Vector3d p = Vector3d::Zero();
    double since = 0;     // when it was found, the last time [s]
    double seen = 0;      // when last [s]
    double lifetime = 0;  // [s]
    bool in_force = false;
    bool found_again = false;  // and has not stood for long since then
  };
  Mark* Find(const Vector3d& p);

  double radius_;
  double lifetime_;
  std::vector<Mark> marks_;  // forgotten ones stay for a while, for their lifetimes
};

}  // namespace cairn::actors
