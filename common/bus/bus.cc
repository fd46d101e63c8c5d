#include "common/bus/bus.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <lcm/lcm-cpp.hpp>
#include <mutex>
#include <regex>
#include <unordered_map>

#include "common/bus/receive_buffer.h"
#include "common/core/check.h"
#include "common/core/hash.h"
#include "common/core/log.h"

namespace cairn {
namespace {

constexpr int kQueueCapacity = 20000;  // LCM's default of 30 loses 14 % at 20k messages a second
constexpr const char* kEchoChannel = "CAIRN_ECHO";
constexpr auto kBrokerPatience = std::chrono::seconds(60);  // at the start; later without end
constexpr auto kOutageIsNews = std::chrono::milliseconds(300);

const std::string& PlaneBroker(const BusConfig& config, Plane plane) {
  return plane == Plane::kTelemetry && !config.telemetry_broker.empty() ? config.telemetry_broker : config.broker;
}

}  // namespace

const char* PlaneChannels(Plane plane) {
  constexpr std::array<const char*, kNumPlanes> kChannels{"CAIRN_(HELLO|STATUS|EXP_.*)",
                                                          "CAIRN_(CONTROL|WELCOME|STATE|POLICY)", "CAIRN_TABLE_.*",
                                                          "CAIRN_(LEARNER|PLANNER|ACTOR_.*)"};
  return kChannels[static_cast<size_t>(plane)];
}

const char* PlaneName(Plane plane) {
  constexpr std::array<const char*, kNumPlanes> kNames{"experience", "control", "tables", "telemetry"};
  return kNames[static_cast<size_t>(plane)];
}

int MaxMessageBytes(int ttl) { return ttl == 0 ? 60000 : 1400; }

std::string PlaneUrl(const BusConfig& config, Plane plane) {
  if (!config.broker.empty()) return "tcpq://" + PlaneBroker(config, plane);
  return fmt::format("udpm://{}:{}?ttl={}&recv_buf_size={}", config.group, config.base_port + static_cast<int>(plane),
                     config.ttl, kWantedReceiveBuffer);
}

std::string ExperienceChannel(int actor_id) { return fmt::format("CAIRN_EXP_{:04}", actor_id); }
std::string ActorChannel(int actor_id) { return fmt::format("CAIRN_ACTOR_{:04}", actor_id); }

// One plane: its LCM instance or its link to the broker, and its handlers. LCM wants a member function; Handler carries
// the bus's checks.
struct Bus::Link {
  struct Handler {
    Link* link;
    std::string channels;
    std::function<void(ByteSpan, const FrameInfo&)> callback;

    void Handle(const lcm::ReceiveBuffer* buffer, const std::string&) {
      // A datagram without NUL in the channel arrives with a size near 2^32.
      const bool sane = buffer->data_size <= 64u << 20;
      Handle({static_cast<const uint8_t*>(buffer->data), sane ? buffer->data_size : 0});
    }
    void Handle(ByteSpan frame) {
      const OpenedFrame& opened = link->Open(frame);
      if (!opened.fault) callback(opened.message, opened.info);
    }
  };

  Link(Bus* b, Plane p) : bus(b), plane(p) {
    if (b->config_.broker.empty()) {
      lcm = std::make_unique<lcm::LCM>(PlaneUrl(b->config_, p));
    } else {
      broker = std::make_unique<BrokerLink>(PlaneBroker(b->config_, p), b->wake_fd_);
    }
  }

  int fd() const { return broker ? broker->fd() : lcm->getFileno(); }

  // Handles one datagram, if one is there: all handlers whose channel fits. `certain` saves a look whether one is.
  bool HandleOne(bool certain) {
    current.reset();
    if (!broker) return certain ? lcm->handle() == 0 : lcm->handleTimeout(0) > 0;
    const std::optional<BrokerLink::Datagram> datagram = broker->Take();
    if (!datagram) return false;
    for (Handler* handler : HandlersOf(datagram->channel)) handler->Handle(ByteSpan(datagram->bytes));
    return true;
  }

  const std::vector<Handler*>& HandlersOf(const std::string& channel) {
    if (by_channel.size() > 4096) by_channel.clear();  // names come from outside
    const auto [found, is_new] = by_channel.try_emplace(channel);
    if (is_new) {
      for (const auto& handler : handlers) {
        if (std::regex_match(channel, std::regex(handler->channels))) found->second.push_back(handler.get());
      }
    }
    return found->second;
  }

  // Opens a frame once however many handlers get it: the second would look like a replay.
  const OpenedFrame& Open(ByteSpan frame) {
    if (current) return *current;
    current = bus->seal_.Open(plane, frame, &bus->peers_);
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
  std::unique_ptr<lcm::LCM> lcm;       // multicast,
  std::unique_ptr<BrokerLink> broker;  // or this
  bool subscribed = false;
  std::vector<std::unique_ptr<Handler>> handlers;
  std::unordered_map<std::string, std::vector<Handler*>> by_channel;
  std::optional<OpenedFrame> current;  // the datagram that is being handled
};

Bus::Bus(BusConfig config)
    : config_(std::move(config)),
      seal_(config_.run_id, config_.key, config_.session),
      receive_buffer_bytes_(config_.broker.empty() ? EffectiveReceiveBuffer() : BrokerLink::kQueueBytes),
      wake_fd_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  CAIRN_CHECK(wake_fd_ >= 0);
}

Bus::~Bus() {
  for (auto& link : links_) link.reset();
  close(wake_fd_);
}

void Bus::Wake() { eventfd_write(wake_fd_, 1); }

int Bus::max_message_bytes() const { return MaxMessageBytes(config_.broker.empty() ? config_.ttl : 0); }

Bus::Link& Bus::link(Plane plane) {
  const std::lock_guard lock(links_mutex_);
  std::unique_ptr<Link>& link = links_[static_cast<size_t>(plane)];
  if (!link) {
    link = std::make_unique<Link>(this, plane);
    if (link->lcm && !link->lcm->good()) {
      ThrowError("LCM {}: cannot join the {} plane; {}", PlaneUrl(config_, plane), PlaneName(plane), kMulticastCure);
    }
  }
  return *link;
}

void Bus::SubscribeBytes(Plane plane, const std::string& channel,
                         std::function<void(ByteSpan, const FrameInfo&)> handler) {
  Link& l = link(plane);
  l.handlers.push_back(std::make_unique<Link::Handler>(Link::Handler{&l, channel, std::move(handler)}));
  l.by_channel.clear();
  l.subscribed = true;
  if (l.broker) return l.broker->Subscribe(channel);
  lcm::Subscription* subscription = l.lcm->subscribe(channel, &Link::Handler::Handle, l.handlers.back().get());
  if (subscription == nullptr) {
    ThrowError("LCM {}: cannot receive on the {} plane; {}", PlaneUrl(config_, plane), PlaneName(plane),
               kMulticastCure);
  }
  subscription->setQueueCapacity(kQueueCapacity);
}

void Bus::PublishBytes(Plane plane, const std::string& channel, Bytes message) {
  seal_.Seal(plane, {config_.session, counter_.fetch_add(1) + 1}, &message);
  Link& l = link(plane);
  if (l.broker) return l.broker->Publish(channel, std::move(message));
  l.lcm->publish(channel, message.data(), static_cast<unsigned>(message.size()));
}

std::optional<Outage> Bus::outage() const {
  if (config_.broker.empty()) return std::nullopt;
  const std::lock_guard lock(links_mutex_);
  for (const auto& link : links_) {
    if (!link) continue;
    const bool alone = std::count(links_.begin(), links_.end(), nullptr) == kNumPlanes - 1;
    if (link->plane == Plane::kTelemetry && !alone) continue;
    if (std::optional<Outage> outage = link->broker->outage()) return outage;
  }
  return std::nullopt;
}

void Bus::NoteOutage() {
  if (config_.broker.empty()) return;
  const std::optional<Outage> now = outage();
  if (now && !outage_noted_ && Clock::now() - now->since > kOutageIsNews) {
    outage_noted_ = now->since;
    log::Warning("broker tcpq://{}: {}; waiting for it", now->broker, now->reason);
  } else if (!now && outage_noted_) {
    log::Warning("the broker is back after {:.1f} s", SecondsSince(*outage_noted_));
    outage_noted_.reset();
  }
}

void Bus::WaitForBroker() {
  const TimePoint deadline = Clock::now() + kBrokerPatience;
  while (const std::optional<Outage> missing = outage()) {
    if (Clock::now() > deadline) {
      ThrowError("LCM tcpq://{}: no broker for {} s: {}; start one: {}", missing->broker, kBrokerPatience.count(),
                 missing->reason, BrokerCommand(missing->broker));
    }
    Poll(std::chrono::milliseconds(20));
  }
}

BusStats Bus::stats() const {
  BusStats stats;
  stats.received = received_.load();
  {
    const std::lock_guard lock(links_mutex_);
    for (const auto& link : links_) stats.dropped += link && link->broker ? link->broker->dropped() : 0;
  }
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
  WaitForBroker();
  for (int p = 0; p < kNumPlanes; ++p) {
    const auto plane = static_cast<Plane>(p);
    if (links_[static_cast<size_t>(p)] && links_[static_cast<size_t>(p)]->subscribed) CheckPlane(plane);
  }
}

// Over a broker the echo is small, since everybody who has begun before gets it too and no buffer is in question, and
// has time: a broker that is asked by many at once answers late.
void Bus::CheckPlane(Plane plane) {
  const bool over_broker = !config_.broker.empty();
  const std::string channel = over_broker ? fmt::format("{}_{}", kEchoChannel, static_cast<int>(plane)) : kEchoChannel;
  const int payload = over_broker ? 100 : max_message_bytes() - 200;
  const auto patience = std::chrono::seconds(over_broker ? 20 : 2);
  const int64_t nonce = RandomId();
  // Shared, since the subscription outlives this call.
  auto returned = std::make_shared<bool>(false);
  Subscribe<Echo>(plane, channel, [returned, nonce](const Echo& echo, const FrameInfo&) {
    if (echo.nonce == nonce) *returned = true;
  });
  const TimePoint deadline = Clock::now() + patience;
  for (TimePoint next = Clock::now(); !*returned && Clock::now() < deadline;) {
    if (Clock::now() >= next) {
      Publish(plane, channel, Echo{nonce, payload});
      next = Clock::now() + std::chrono::milliseconds(100);
    }
    Poll(std::chrono::milliseconds(20));
  }
  if (*returned) return;
  const std::optional<Outage> missing = outage();
  ThrowError("LCM {}: an echo of {} bytes on the {} plane did not come back within {} s; {}", PlaneUrl(config_, plane),
             payload, PlaneName(plane), patience.count(),
             !over_broker ? kMulticastCure
             : missing    ? missing->reason
                          : "has another subscriber of the broker stopped?");
}

int Bus::Poll(Duration timeout) {
  NoteOutage();
  std::array<pollfd, kNumPlanes + 1> fds{};
  std::array<Link*, kNumPlanes> polled{};
  nfds_t count = 0;
  for (auto& l : links_) {
    if (!l || !l->subscribed) continue;
    fds[count] = {l->fd(), POLLIN, 0};
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
