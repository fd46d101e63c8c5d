#include "learner/credit_ledger.h"

#include <algorithm>

namespace cairn::learner {
namespace {

int64_t Unused(const ActorRecord& actor) { return std::max<int64_t>(0, actor.credit - actor.accepted); }

}  // namespace

void CreditLedger::Allow(int64_t allowed) { allowed_ = std::max(allowed_, std::min(allowed, total_)); }

bool CreditLedger::Distribute(Fleet* fleet, double share, TimePoint now) {
  const int num_actors = fleet->num_joined();
  if (num_actors == 0) return false;
  int64_t unused = 0;
  int64_t committed = retired_;
  for (const auto& [id, actor] : fleet->actors()) {
    unused += Unused(actor);
    committed += std::max(actor.credit, actor.accepted);
  }
  int64_t free = allowed_ - committed;
  const bool enough = static_cast<double>(free) >= share * static_cast<double>(enough_) || allowed_ == total_;
  if (free <= 0 || (!enough && now - distributed_ < kPatience)) return false;
  distributed_ = now;
  // The level to which each is filled up; what rounding leaves goes to the first.
  const int64_t level = (unused + free) / num_actors + 1;
  for (auto& [id, actor] : fleet->actors()) {
    if (!actor.joined) continue;
    const int64_t more = std::min(free, level - Unused(actor));
    if (more <= 0) continue;
    actor.credit = std::max(actor.credit, actor.accepted) + more;
    free -= more;
  }
  return true;
}

}  // namespace cairn::learner
