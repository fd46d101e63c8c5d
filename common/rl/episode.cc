#include "common/rl/episode.h"

namespace cairn {

const char* OutcomeName(Outcome outcome) {
  switch (outcome) {
    case Outcome::kRunning:
      return "running";
    case Outcome::kGoal:
      return "goal";
    case Outcome::kCollision:
      return "collision";
    case Outcome::kTimeout:
      return "timeout";
    case Outcome::kDiverged:
      return "diverged";
  }
  return "unknown";
}

}  // namespace cairn
