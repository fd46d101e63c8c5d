// The reliable stream between a sender and a receiver over a wire that loses, doubles and reorders as the input says,
// with receivers that restart and positions made up by a stranger. In the end everything must have come exactly once,
// in order.
#include <fuzzer/FuzzedDataProvider.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <deque>

#include "common/bus/reliable_stream.h"

namespace cairn {
namespace {

constexpr size_t kNumberAt = 24;

Bytes Numbered(int64_t number, size_t size) {
  Bytes bytes(kNumberAt + 8 + size, 0);
  for (size_t i = 0; i < 8; ++i) bytes[kNumberAt + i] = static_cast<uint8_t>(number >> (8 * i));
  return bytes;
}

int64_t Number(const Bytes& bytes) {
  int64_t number = 0;
  for (size_t i = 0; i < 8; ++i) number |= int64_t{bytes[kNumberAt + i]} << (8 * i);
  return number;
}

void Expect(bool condition) {
  if (!condition) std::abort();
}

class Machine {
 public:
  void Run(FuzzedDataProvider* input) {
    while (input->remaining_bytes() > 0) Step(input);
    for (int i = 0; i < 2000 && !sender_.idle(); ++i) {
      now_ += std::chrono::milliseconds(400);
      sender_.Poll(now_);
      while (!wire_.empty()) Deliver(0);
      Acknowledge();
    }
    Expect(sender_.idle() && delivered_ == sender_.last_sequence());
  }

 private:
  void Step(FuzzedDataProvider* input) {
    switch (input->ConsumeIntegralInRange<int>(0, 8)) {
      case 0:
        return sender_.Push(Numbered(sender_.next_sequence(), input->ConsumeIntegral<uint8_t>()), now_);
      case 1:
        now_ += std::chrono::microseconds(input->ConsumeIntegral<uint16_t>());
        return sender_.Poll(now_);
      case 2:
        if (!wire_.empty()) Deliver(input->ConsumeIntegralInRange<size_t>(0, wire_.size() - 1));
        return;
      case 3:
        if (!wire_.empty()) wire_.pop_front();  // lost
        return;
      case 4:
        if (!wire_.empty()) wire_.push_back(wire_.front());  // doubled
        return;
      case 5:
        return Acknowledge();
      case 6:  // stale or foreign: behind what was received, or never sent
        return sender_.Acknowledge(
            {input->ConsumeBool() ? 0 : sender_.next_sequence() + input->ConsumeIntegral<uint8_t>(),
             0,
             window_,
             0,
             {{input->ConsumeIntegral<int64_t>(), input->ConsumeIntegral<int64_t>()}}},
            now_);
      case 7:
        window_ = input->ConsumeIntegral<uint16_t>();
        return;
      default:
        return Restart(input->ConsumeIntegralInRange<int64_t>(durable_, delivered_));
    }
  }

  void Deliver(size_t index) {
    const int64_t number = wire_[index];
    wire_.erase(wire_.begin() + static_cast<std::ptrdiff_t>(index));
    receiver_.Accept(number, number);
    while (const auto next = receiver_.Take()) Expect(*next == ++delivered_);
  }

  void Acknowledge() {
    receiver_.Announce(sender_.last_sequence());
    durable_ = std::max(durable_, delivered_ / 2);
    sender_.Acknowledge({receiver_.received(), durable_, window_, 0, receiver_.Gaps(8)}, now_);
  }

  // The receiver's process dies; the next one has what was received up to some point behind the durable one.
  void Restart(int64_t received) {
    receiver_ = ReliableReceiver<int64_t>(received);
    delivered_ = durable_ = received;  // it is what a checkpoint held
    wire_.clear();
    Expect(sender_.Rewind(received, now_));
  }

  ReliableSender sender_{[this](const Bytes& bytes) { wire_.push_back(Number(bytes)); }};
  ReliableReceiver<int64_t> receiver_;
  std::deque<int64_t> wire_;
  TimePoint now_{};
  int64_t window_ = 2000;
  int64_t delivered_ = 0;
  int64_t durable_ = 0;
};

}  // namespace
}  // namespace cairn

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  FuzzedDataProvider input(data, size);
  cairn::Machine().Run(&input);
  return 0;
}
