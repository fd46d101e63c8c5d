#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "common/bus/broker_link.h"
#include "common/bus/codec.h"
#include "common/bus/frame.h"
#include "common/bus/plane.h"
#include "common/bus/replay_window.h"
#include "common/core/clock.h"

namespace cairn {

struct BusConfig {
  std::string group = "239.255.76.67";
  int base_port = 7700;
  int ttl = 0;
  int64_t run_id = 0;
  int64_t session = 0;           ///< of this process; goes into every trailer; random, never that of another Bus
  std::optional<RunKey> key;     ///< seals all frames with it and takes no others; none: CRC32C
  std::string broker;            ///< "HOST:PORT" of an LCM broker that carries all planes; empty: multicast as above
  std::string telemetry_broker;  ///< of another one for telemetry; empty: `broker`
};

/// Largest message [bytes] to send over multicast: 60 kB on loopback, 1400 B between hosts (ttl ≥ 1), trailer included.
int MaxMessageBytes(int ttl);

/// LCM URL of a plane, for lcm-spy and for errors.
std::string PlaneUrl(const BusConfig& config, Plane plane);

/// LCM regular expression of all channels of a plane; on a broker, which carries all planes, nothing else tells them
/// apart.
const char* PlaneChannels(Plane plane);

struct BusStats {
  int64_t received = 0;
  int64_t dropped = 0;  ///< over a broker: had no place in a queue, or no broker to go to
  int64_t refused = 0;  ///< of all faults together
  std::array<int64_t, kNumFrameFaults> faults{};

  int64_t of(FrameFault fault) const { return faults[static_cast<size_t>(fault)]; }
};

/// Typed publish/subscribe over the planes. Planes open on first use; a plane that is only published on costs no
/// receiving. Poll runs handlers on the calling thread; Publish may be called from any thread. Create it after fork.
/// Over a broker (tcpq) nothing throws when that is missing or goes away: messages are lost meanwhile, as on a network,
/// outage() and the log say so, and all goes on when it is back.
class Bus {
 public:
  /// Throws Error with the cure when the group cannot be reached (no multicast route).
  explicit Bus(BusConfig config);
  ~Bus();
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;

  template <typename Message>
  void Publish(Plane plane, const std::string& channel, const Message& message) {
    PublishBytes(plane, channel, Encode(message));
  }

  /// Calls `handler` for every sound message on `channel` (an LCM regular expression) of this run. Messages of other
  /// runs, forged, repeated and torn ones and ones that do not decode are counted and dropped. Handlers must not throw.
  template <typename Message>
  void Subscribe(Plane plane, const std::string& channel, std::function<void(Message&&, const FrameInfo&)> handler) {
    SubscribeBytes(plane, channel, [this, plane, handler = std::move(handler)](ByteSpan bytes, const FrameInfo& info) {
      std::optional<Message> message = Decode<Message>(bytes);
      if (message) {
        handler(std::move(*message), info);
      } else {
        Refuse(plane, FrameFault::kUndecodable);
      }
    });
  }

  /// Sends an echo of the largest message size to itself on each subscribed plane and waits for it. Throws Error with a
  /// diagnosis and the cure when one does not come back; a broker is waited for a minute. Call once, after subscribing.
  void CheckPlanes();

  /// Handles what has arrived, waiting up to `timeout` for the first message. Returns the number of messages handled.
  int Poll(Duration timeout);

  /// Ends the wait of the Poll that is under way, or of the next. From any thread.
  void Wake();

  /// Publishes encoded bytes; a frame trailer is added.
  void PublishBytes(Plane plane, const std::string& channel, Bytes message);
  void SubscribeBytes(Plane plane, const std::string& channel, std::function<void(ByteSpan, const FrameInfo&)> handler);

  const BusConfig& config() const { return config_; }
  BusStats stats() const;
  /// Why no messages travel over the broker now; empty: they do, or there is none. A stuck telemetry plane does not
  /// count where others are in use.
  std::optional<Outage> outage() const;
  /// Largest message to send [bytes], trailer included: over a broker as on loopback.
  int max_message_bytes() const;
  /// Receive buffer the kernel (over a broker: this process) really gives [bytes]; bounds what may be outstanding.
  int receive_buffer_bytes() const { return receive_buffer_bytes_; }

 private:
  struct Link;
  Link& link(Plane plane);
  void Refuse(Plane plane, FrameFault fault);
  void CheckPlane(Plane plane);
  void WaitForBroker();
  void NoteOutage();

  BusConfig config_;
  FrameSeal seal_;
  // Of the thread that polls.
  PeerContexts peers_;
  ReplayGuard replay_guard_;
  int receive_buffer_bytes_ = 0;
  std::atomic<uint64_t> counter_{0};
  std::atomic<int64_t> received_{0};
  std::array<std::atomic<int64_t>, kNumFrameFaults> refused_{};
  std::optional<TimePoint> outage_noted_;  // of the thread that polls: when the outage that is on began
  mutable std::mutex links_mutex_;         // guards opening a plane; an open one stays
  std::array<std::unique_ptr<Link>, kNumPlanes> links_;
  const int wake_fd_;
};

// Channel names: ≤ 20 characters are readable in lcm-spy; ids have fixed width; no counters in names.
constexpr const char* kControlChannel = "CAIRN_CONTROL";
constexpr const char* kWelcomeChannel = "CAIRN_WELCOME";
constexpr const char* kStateChannel = "CAIRN_STATE";
constexpr const char* kPolicyChannel = "CAIRN_POLICY";
constexpr const char* kHelloChannel = "CAIRN_HELLO";
constexpr const char* kStatusChannel = "CAIRN_STATUS";
constexpr const char* kTableRequestChannel = "CAIRN_TABLE_REQUEST";
constexpr const char* kTableInfoChannel = "CAIRN_TABLE_INFO";
constexpr const char* kTableChunkChannel = "CAIRN_TABLE_CHUNK";
constexpr const char* kLearnerChannel = "CAIRN_LEARNER";
constexpr const char* kPlannerChannel = "CAIRN_PLANNER";
/// "CAIRN_EXP_0003".
std::string ExperienceChannel(int actor_id);
constexpr const char* kExperienceChannels = "CAIRN_EXP_.*";
/// "CAIRN_ACTOR_0003".
std::string ActorChannel(int actor_id);

}  // namespace cairn
