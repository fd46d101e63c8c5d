#include "common/bus/bus.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <lcm/lcm-cpp.hpp>
#include <mutex>

#include "common/bus/receive_buffer.h"
#include "common/core/check.h"
#include "common/core/hash.h"
#include "common/core/log.h"

namespace cairn {
namespace {

constexpr int kQueueCapacity = 20000;  // LCM's default of 30 loses 14 % at 20k messages a second
constexpr const char* kEchoChannel = "CAIRN_ECHO";

constexpr const char* kCure =
    "check the multicast route (`ip route get 239.255.76.67`); on one host: "
    "`sudo ip route add 224.0.0.0/4 dev lo`";

}  // namespace

const char* PlaneName(Plane plane) {
  constexpr std::array<const char*, kNumPlanes> kNames{"experience", "control", "tables", "telemetry"};
  return kNames[static_cast<size_t>(plane)];
}

int MaxMessageBytes(int ttl) { return ttl == 0 ? 60000 : 1400; }

std::string PlaneUrl(const BusConfig& config, Plane plane) {
  return fmt::format("udpm://{}:{}?ttl={}&recv_buf_size={}", config.group, config.base_port + static_cast<int>(plane),
                     config.ttl, kWantedReceiveBuffer);
}

std::string ExperienceChannel(int actor_id) { return fmt::format("CAIRN_EXP_{:04}", actor_id); }
std::string ActorChannel(int actor_id) { return fmt::format("CAIRN_ACTOR_{:04}", actor_id); }

// One LCM instance and its handlers. LCM wants a member function; Handler carries the bus's checks.
struct Bus::Link {
  struct Handler {
    Link* link;
    std::function<void(ByteSpan, const FrameInfo&)> callback;

    void Handle(const lcm::ReceiveBuffer* buffer, const std::string&) {
      const OpenedFrame& opened = link->Open(buffer);
      if (!opened.fault) callback(opened.message, opened.info);
    }
  };

  Link(Bus* b, Plane p) : bus(b), plane(p), lcm(PlaneUrl(b->config_, p)) {}

  // Handles one datagram, if one is there: all handlers whose channel fits. `certain` saves a look whether one is.
  bool HandleOne(bool certain) {
    current.reset();
    return certain ? lcm.handle() == 0 : lcm.handleTimeout(0) > 0;
  }

  // Opens a frame once however many handlers get it: the second would look like a replay.
  const OpenedFrame& Open(const lcm::ReceiveBuffer* buffer) {
    if (current) return *current;
    // A datagram without NUL in the channel arrives with a size near 2^32.
    const bool sane = buffer->data_size <= 64u << 20;
    current =
        bus->seal_.Open(plane, {static_cast<const uint8_t*>(buffer->data), sane ? buffer->data_size : 0}, &bus->peers_);
    const FrameInfo& info = current->info;
    // Without a key anyone can send any counter, so there is nothing to hold on to.
    if (!current->fault && bus->seal_.keyed() && !bus->replay_guard_.Accept(plane, info.session, info.counter)) {
      current->fault = FrameFault::kReplay;
    }
    if (current->fault) {
      bus->Refuse(plane, *current->fault);
    } else {
      bus->received_.fetch_add(1, std::memory_order_relaxed);
    }
    return *current;
  }

  Bus* bus;
  Plane plane;
  lcm::LCM lcm;
  bool subscribed = false;
  std::vector<std::unique_ptr<Handler>> handlers;
  std::optional<OpenedFrame> current;  // the datagram that is being handled
};

Bus::Bus(BusConfig config)
    : config_(std::move(config)),
      seal_(config_.run_id, config_.key, config_.session),
      receive_buffer_bytes_(EffectiveReceiveBuffer()),
      wake_fd_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  CAIRN_CHECK(wake_fd_ >= 0);
}

Bus::~Bus() { close(wake_fd_); }

void Bus::Wake() { eventfd_write(wake_fd_, 1); }

Bus::Link& Bus::link(Plane plane) {
  const std::lock_guard lock(links_mutex_);
  std::unique_ptr<Link>& link = links_[static_cast<size_t>(plane)];
  if (!link) {
    link = std::make_unique<Link>(this, plane);
    if (!link->lcm.good()) {
      ThrowError("LCM {}: cannot join the {} plane; {}", PlaneUrl(config_, plane), PlaneName(plane), kCure);
    }
  }
  return *link;
}

void Bus::SubscribeBytes(Plane plane, const std::string& channel,
                         std::function<void(ByteSpan, const FrameInfo&)> handler) {
  Link& l = link(plane);
  l.handlers.push_back(std::make_unique<Link::Handler>(Link::Handler{&l, std::move(handler)}));
  lcm::Subscription* subscription = l.lcm.subscribe(channel, &Link::Handler::Handle, l.handlers.back().get());
  if (subscription == nullptr) {
    ThrowError("LCM {}: cannot receive on the {} plane; {}", PlaneUrl(config_, plane), PlaneName(plane), kCure);
  }
  subscription->setQueueCapacity(kQueueCapacity);
  l.subscribed = true;
}

void Bus::PublishBytes(Plane plane, const std::string& channel, Bytes message) {
  seal_.Seal(plane, {config_.session, counter_.fetch_add(1) + 1}, &message);
  link(plane).lcm.publish(channel, message.data(), static_cast<unsigned>(message.size()));
}

BusStats Bus::stats() const {
  BusStats stats;
  stats.received = received_.load();
  for (int i = 0; i < kNumFrameFaults; ++i) {
    stats.faults[static_cast<size_t>(i)] = refused_[static_cast<size_t>(i)].load();
    stats.refused += stats.faults[static_cast<size_t>(i)];
  }
  return stats;
}

// Each fault is said once: enough to find a forgotten key, and nobody can fill the log.
void Bus::Refuse(Plane plane, FrameFault fault) {
  if (refused_[static_cast<size_t>(fault)].fetch_add(1, std::memory_order_relaxed) > 0) return;
  log::Warning("refused a datagram on the {} plane: {}; more of this kind are only counted", PlaneName(plane),
               FrameFaultName(fault));
}

void Bus::CheckPlanes() {
  for (int p = 0; p < kNumPlanes; ++p) {
    const auto plane = static_cast<Plane>(p);
    if (!links_[static_cast<size_t>(p)] || !links_[static_cast<size_t>(p)]->subscribed) continue;
    const int64_t nonce = RandomId();
    // Shared, since the subscription outlives this call.
    auto returned = std::make_shared<bool>(false);
    Subscribe<Echo>(plane, kEchoChannel, [returned, nonce](const Echo& echo, const FrameInfo&) {
      if (echo.nonce == nonce) *returned = true;
    });
    const int payload = MaxMessageBytes(config_.ttl) - 200;
    const TimePoint deadline = Clock::now() + std::chrono::seconds(2);
    for (TimePoint next = Clock::now(); !*returned && Clock::now() < deadline;) {
      if (Clock::now() >= next) {
        Publish(plane, kEchoChannel, Echo{nonce, payload});
        next = Clock::now() + std::chrono::milliseconds(100);
      }
      Poll(std::chrono::milliseconds(20));
    }
    if (!*returned) {
      ThrowError("LCM {}: an echo of {} bytes on the {} plane did not come back within 2 s; {}",
                 PlaneUrl(config_, plane), payload, PlaneName(plane), kCure);
    }
  }
}

int Bus::Poll(Duration timeout) {
  std::array<pollfd, kNumPlanes + 1> fds{};
  std::array<Link*, kNumPlanes> polled{};
  nfds_t count = 0;
  for (auto& l : links_) {
    if (!l || !l->subscribed) continue;
    fds[count] = {l->lcm.getFileno(), POLLIN, 0};
    polled[count++] = l.get();
  }
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(timeout).count();
  const timespec wait{us / 1000000, (us % 1000000) * 1000};
  fds[count] = {wake_fd_, POLLIN, 0};
  if (ppoll(fds.data(), count + 1, us < 0 ? nullptr : &wait, nullptr) <= 0) return 0;
  if ((fds[count].revents & POLLIN) != 0) {
    eventfd_t ignored = 0;
    eventfd_read(wake_fd_, &ignored);
  }
  int handled = 0;
  for (nfds_t i = 0; i < count; ++i) {
    if ((fds[i].revents & POLLIN) == 0) continue;
    // Bounded, so that a flood on one plane cannot starve the caller.
    for (int n = 0; n < 1024 && polled[i]->HandleOne(n == 0); ++n) ++handled;
  }
  return handled;
}

}  // namespace cairn
