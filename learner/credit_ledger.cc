#include "learner/credit_ledger.h"

#include <algorithm>
#include <vector>

namespace cairn::learner {
namespace {

constexpr int64_t kIdleShare = 8;

int64_t Unused(const ActorRecord& actor) { return std::max<int64_t>(0, actor.credit - actor.accepted); }

}  // namespace

void CreditLedger::Allow(int64_t allowed) { allowed_ = std::max(allowed_, std::min(allowed, total_)); }

bool CreditLedger::Distribute(Fleet* fleet, Duration patience, TimePoint now) {
  const int num_actors = fleet->num_joined();
  if (num_actors == 0) return false;
  int64_t unused = 0;
  int64_t committed = retired_;
  for (const auto& [id, actor] : fleet->actors()) {
    unused += Unused(actor);
    committed += std::max(actor.credit, actor.accepted);
  }
  int64_t free = allowed_ - committed;
  const bool enough = free >= enough_ || allowed_ == total_;
  if (free <= 0 || (!enough && now - distributed_ < patience)) return false;
  distributed_ = now;
  // The level to which each is filled up; what rounding leaves goes to the first.
  int64_t level = (unused + free) / num_actors + 1;
  std::vector<ActorRecord*> order;
  for (auto& [id, actor] : fleet->actors()) {
    if (actor.joined) order.push_back(&actor);
  }
  // When hardly anybody has anything left, credit is what they wait for, and a few steps for each now would only be as
  // many starts with cold caches: whoever waits longest gets a burst.
  if (level < burst_ && kIdleShare * unused <= free) {
    level = burst_;
    std::stable_sort(order.begin(), order.end(),
                     [](const ActorRecord* a, const ActorRecord* b) { return a->credit_turn < b->credit_turn; });
  }
  ++turn_;
  for (ActorRecord* actor : order) {
    const int64_t more = std::min(free, level - Unused(*actor));
    if (more <= 0) continue;
    actor->credit = std::max(actor->credit, actor->accepted) + more;
    actor->credit_turn = turn_;
    free -= more;
  }
  return true;
}

}  // namespace cairn::learner
