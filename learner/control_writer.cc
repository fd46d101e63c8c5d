#include "learner/control_writer.h"

#include <algorithm>

namespace cairn::learner {
namespace {

constexpr int kHeadBytes = 300;  // of a frame with two rounds, trailer included
constexpr int kActorBytes = 60;
constexpr int kGapBytes = 20;
constexpr size_t kMaxGaps = 64;  // in one frame

}  // namespace

int64_t ControlWriter::Window(const Fleet& fleet) const {
  return bus_->receive_buffer_bytes() / 2 / std::max(1, fleet.num_joined());
}

void ControlWriter::Send(const EvaluationQueue& evaluations, bool keeps, Fleet* fleet, Control* control) const {
  const int room = bus_->max_message_bytes() - kHeadBytes;
  const int64_t window = Window(*fleet);
  const int num_joined = fleet->num_joined();
  int used = 0;
  int rank = 0;
  size_t gaps_left = kMaxGaps;
  const auto send = [&] {
    ++control->number;
    bus_->Publish(Plane::kControl, kControlChannel, *control);
    control->actors.clear();
    used = 0;
    gaps_left = kMaxGaps;
  };
  control->actors.clear();
  for (auto& [id, actor] : fleet->actors()) {
    actor.unannounced_bytes = 0;
    if (!actor.joined) continue;
    if (used + kActorBytes > room) send();
    const auto [first, end] = evaluations.Share(rank++, num_joined);
    Control::Actor position;
    position.actor_id = actor.actor_id;
    position.session = actor.session;
    position.received = actor.stream.received();
    position.durable = keeps ? actor.durable : position.received;
    position.credit = actor.credit;
    position.window = window;
    position.echo_us = actor.echo_us;
    position.evaluation_first = first;
    position.evaluation_count = end - first;
    position.gaps =
        actor.stream.Gaps(std::min(gaps_left, static_cast<size_t>((room - used - kActorBytes) / kGapBytes)));
    gaps_left -= position.gaps.size();
    used += kActorBytes + static_cast<int>(position.gaps.size()) * kGapBytes;
    control->actors.push_back(std::move(position));
  }
  send();
}

}  // namespace cairn::learner
