#include "learner/policy_outbox.h"

#include <algorithm>
#include <utility>

#include "common/core/hash.h"

namespace cairn::learner {
namespace {

constexpr auto kResendGap = std::chrono::milliseconds(10);  // several actors may ask for the same version at once
constexpr size_t kKept = 4;
constexpr int kChunkOverhead = 128;  // bytes of a message that are not parameters

}  // namespace

void PolicyOutbox::Add(int64_t version, std::span<const float> parameters) {
  const auto [it, added] = policies_.try_emplace(version);
  if (!added) return;
  it->second.parameters.assign(parameters.begin(), parameters.end());
  Send(version, &it->second);
}

std::vector<float> PolicyOutbox::Find(int64_t version) const {
  const auto it = policies_.find(version);
  return it == policies_.end() ? std::vector<float>() : it->second.parameters;
}

void PolicyOutbox::Resend(int64_t version, TimePoint now) {
  const auto it = policies_.find(version);
  if (it != policies_.end() && now - it->second.sent_at > kResendGap) Send(version, &it->second);
}

void PolicyOutbox::DropUnused(const std::function<bool(int64_t version)>& in_use) {
  for (auto it = policies_.begin(); it != policies_.end() && policies_.size() > kKept;) {
    it = in_use(it->first) ? std::next(it) : policies_.erase(it);
  }
}

void PolicyOutbox::Send(int64_t version, Entry* entry) {
  const std::vector<float>& parameters = entry->parameters;
  const auto chunk = static_cast<size_t>((bus_->max_message_bytes() - kChunkOverhead) / 4);
  PolicyChunk message;
  message.incarnation = incarnation_;
  message.version = version;
  message.parameters_crc = Crc32c(parameters.data(), parameters.size() * sizeof(float));
  message.total = static_cast<int32_t>(parameters.size());
  for (size_t at = 0; at < parameters.size(); at += chunk) {
    const size_t end = std::min(at + chunk, parameters.size());
    message.offset = static_cast<int32_t>(at);
    message.parameters.assign(parameters.begin() + static_cast<std::ptrdiff_t>(at),
                              parameters.begin() + static_cast<std::ptrdiff_t>(end));
    bus_->Publish(Plane::kControl, kPolicyChannel, message);
  }
  entry->sent_at = Clock::now();
}

}  // namespace cairn::learner
