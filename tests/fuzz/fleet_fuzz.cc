// The learner's books under any sequence of hellos, statuses, segments, departures and deaths: no crash, and every
// vehicle's accepted steps continue each other.
#include <fuzzer/FuzzedDataProvider.h>

#include <cstdint>
#include <cstdlib>
#include <map>

#include "learner/fleet.h"
#include "learner/open_rounds.h"

namespace cairn::learner {
namespace {

constexpr int kVehicles = 4;

Segment MakeSegment(FuzzedDataProvider* input) {
  Segment s;
  s.vehicle = input->ConsumeIntegralInRange<int32_t>(-1, kVehicles);
  s.episode = input->ConsumeIntegralInRange<int32_t>(-1, 5);
  s.first_step = input->ConsumeIntegralInRange<int32_t>(-1, 9);
  s.end = static_cast<SegmentEnd>(input->ConsumeIntegralInRange<int>(0, 3));
  const size_t steps = input->ConsumeIntegralInRange<size_t>(1, 3);
  s.observations.assign(steps + 1, input->ConsumeBool() ? 0.0f : 1e38f * 10);
  s.actions.assign(2 * steps, 0.0f);
  s.rewards.assign(steps, 0.0f);
  return s;
}

class Machine {
 public:
  void Run(FuzzedDataProvider* input) {
    rounds_.Grant(5, 1, 0, false);
    while (input->remaining_bytes() > 0) Step(input);
  }

 private:
  void Step(FuzzedDataProvider* input) {
    const int32_t id = input->ConsumeIntegralInRange<int32_t>(0, 3);
    const int64_t session = input->ConsumeIntegralInRange<int64_t>(1, 8);
    now_ += std::chrono::milliseconds(input->ConsumeIntegral<uint16_t>());
    ActorRecord* actor = fleet_.Find(session);
    switch (input->ConsumeIntegralInRange<int>(0, 7)) {
      case 0: {
        Hello hello;
        hello.session = session;
        hello.actor_id = id;
        hello.generation = input->ConsumeIntegralInRange<int32_t>(0, 3);
        hello.transitions = input->ConsumeIntegralInRange<int64_t>(0, 1);
        fleet_.Join(hello, now_);
        return;
      }
      case 1:
        if (fleet_.num_joined() > 0) fleet_.Start();
        return;
      case 2:
        if (fleet_.actors().contains(id)) fleet_.Share(id);
        return;
      case 3:
        if (fleet_.actors().contains(id)) fleet_.Leave(id);
        return;
      case 4:
        fleet_.Settle();
        return;
      case 5:
        if (fleet_.actors().contains(id)) fleet_.Reassign(id);
        return;
      case 6:
        if (actor == nullptr) return;
        actor->status.assignment = input->ConsumeIntegralInRange<int64_t>(0, 20);
        actor->status.last_sequence = input->ConsumeIntegralInRange<int64_t>(0, 1);
        if (fleet_.Gone(*actor)) fleet_.Forget(actor->actor_id);
        return;
      default:
        if (actor != nullptr) Offer(*actor, MakeSegment(input));
    }
  }

  void Offer(const ActorRecord& actor, const Segment& segment) {
    if (fleet_.Judge(actor, segment) != Fleet::Verdict::kSound) return;
    const auto v = static_cast<size_t>(segment.vehicle);
    if (!rounds_.Add(segment, fleet_.vehicles()[v].steps)) return;
    int32_t& next = next_step_[{segment.vehicle, segment.episode}];
    if (segment.first_step != next) std::abort();
    next += segment.num_steps();
    fleet_.Accept(segment);
    if (rounds_.front_complete()) rounds_.TakeFront();
    if (rounds_.missing() == 0) rounds_.Grant(5, 0, 0, false);
  }

  Fleet fleet_{2, kVehicles, 0, 0, ""};
  OpenRounds rounds_{kVehicles};
  TimePoint now_{std::chrono::hours(1)};
  std::map<std::pair<int32_t, int32_t>, int32_t> next_step_;
};

}  // namespace
}  // namespace cairn::learner

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  FuzzedDataProvider input(data, size);
  cairn::learner::Machine().Run(&input);
  return 0;
}
