#include "common/bus/robot_link.h"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <lcm/lcm-cpp.hpp>
#include <utility>

#include "common/bus/codec.h"
#include "common/bus/plane.h"
#include "common/core/check.h"

namespace cairn {
namespace {

constexpr size_t kMaxName = 12;  // channels of at most 20 characters

void CheckName(const std::string& name) {
  const bool sound = !name.empty() && name.size() <= kMaxName && std::all_of(name.begin(), name.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
  });
  if (!sound) ThrowUsageError("--name {}: it must be 1 to {} letters, digits and underscores", name, kMaxName);
}

}  // namespace

struct RobotLink::Lcm {
  Lcm(const RobotAddress& address, End e)
      : end(e),
        lcm(address.url()),
        heard(address.name + (e == End::kDriver ? "_STATE" : "_COMMAND")),
        sent(address.name + (e == End::kDriver ? "_COMMAND" : "_STATE")) {}

  void Handle(const lcm::ReceiveBuffer* buffer, const std::string&) {
    // A datagram without NUL in the channel arrives with a size near 2^32.
    const bool sane = buffer->data_size <= 64u << 20;
    const ByteSpan bytes(static_cast<const uint8_t*>(buffer->data), sane ? buffer->data_size : 0);
    const bool sound =
        end == End::kDriver ? Keep(Decode<RobotState>(bytes), &state) : Keep(Decode<RobotCommand>(bytes), &command);
    if (!sound) ++refused;
  }

  template <typename Message>
  static bool Keep(std::optional<Message> message, std::optional<Message>* newest) {
    if (!message) return false;
    *newest = std::move(message);
    return true;
  }

  void Publish(const Bytes& bytes) { lcm.publish(sent, bytes.data(), static_cast<unsigned>(bytes.size())); }

  // Handles all that is there, after waiting for the first.
  template <typename Message>
  std::optional<Message> Wait(Duration timeout, std::optional<Message>* newest) {
    const TimePoint deadline = Clock::now() + timeout;
    while (!newest->has_value()) {
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now()).count();
      if (left <= 0 || lcm.handleTimeout(static_cast<int>(left)) < 0) break;
    }
    while (lcm.handleTimeout(0) > 0) {
    }
    return std::exchange(*newest, std::nullopt);
  }

  const End end;
  lcm::LCM lcm;
  const std::string heard, sent;  // channels
  std::optional<RobotState> state;
  std::optional<RobotCommand> command;
  int64_t refused = 0;
};

std::string RobotAddress::url() const { return fmt::format("udpm://{}:{}?ttl={}", group, port, ttl); }

RobotLink::RobotLink(const RobotAddress& address, End end) {
  CheckName(address.name);
  lcm_ = std::make_unique<Lcm>(address, end);
  if (!lcm_->lcm.good() || lcm_->lcm.subscribe(lcm_->heard, &Lcm::Handle, lcm_.get()) == nullptr) {
    ThrowError("LCM {}: cannot join; {}", address.url(), kMulticastCure);
  }
}

RobotLink::~RobotLink() = default;

void RobotLink::Send(const RobotState& state) { lcm_->Publish(Encode(state)); }

void RobotLink::Send(const RobotCommand& command) { lcm_->Publish(Encode(command)); }

std::optional<RobotState> RobotLink::WaitForState(Duration timeout) { return lcm_->Wait(timeout, &lcm_->state); }

std::optional<RobotCommand> RobotLink::WaitForCommand(Duration timeout) { return lcm_->Wait(timeout, &lcm_->command); }

int64_t RobotLink::refused() const { return lcm_->refused; }

const std::string& RobotLink::channel() const { return lcm_->heard; }

}  // namespace cairn
