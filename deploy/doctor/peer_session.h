#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/bus/plane.h"
#include "common/core/bytes.h"

namespace cairn::deploy {

/// What two hosts found out about the way between them.
struct PeerResult {
  int probes = 0;                                 ///< that each side sent
  std::array<int, kNumPlanes> sent_arrived{};     ///< of ours, as the peer counted, by plane
  std::array<int, kNumPlanes> received{};         ///< of the peer's, by plane
  std::array<int, kNumPlanes> probes_of_plane{};  ///< that each side sent there
  std::vector<double> round_trips_us;             ///< of probes that were answered, ascending
  std::optional<double> clock_offset_us;          ///< peer's wall clock less ours, from the fastest round trip
  double lost_to_peer() const;                    ///< share of ours, 0 … 1
  double lost_from_peer() const;                  ///< share of the peer's, 0 … 1
  double round_trip_us(double quantile) const;    ///< 0 when there are none
};

/// One side of the measurement, without sockets and clocks: both sides say hello until each knows of the other, send
/// their probes, answer those of the other one, and end when each knows what the other has counted. Any datagram but a
/// probe may be lost, since states are repeated; lost probes are what is counted.
class PeerSession {
 public:
  /// `id`: random, of this side. `probes`: each way; the other side must be told the same.
  PeerSession(int64_t id, int probes);

  /// Bytes of a probe, so that it is as long as a plane's largest message.
  static constexpr size_t kProbeBytes = 1380;

  /// Takes a datagram that came in on `plane`; returns the answer to send there, if it wants one. `now_us` monotonic,
  /// `wall_us` of the wall clock.
  std::optional<Bytes> Handle(ByteSpan datagram, int plane, int64_t now_us, int64_t wall_us);

  /// What to say every 50 ms on all planes.
  Bytes State() const;

  /// The next probe; goes to plane `number % kNumPlanes`. Empty before the sides are paired and after the last.
  std::optional<Bytes> NextProbe(int64_t now_us);
  int sent() const { return sent_; }
  bool sending() const { return paired_ && sent_ < total_; }

  /// The peer is heard / hears us too.
  bool heard() const { return peer_ != 0; }
  bool paired() const { return paired_; }
  /// How many probes the peer sends; differs from ours when they were told different numbers.
  int peer_probes() const { return peer_total_; }
  /// Both sides have counted.
  bool finished() const { return final_ && peer_final_; }
  /// To be called now and then: notices that nothing more is on the way.
  void Tick(int64_t now_us);
  /// When something last came from the peer, monotonic; 0: never.
  int64_t last_heard_us() const { return last_heard_us_; }

  PeerResult Result() const;

 private:
  void HandleState(class WireReader* reader);
  Bytes HandleProbe(class WireReader* reader, int plane, int64_t wall_us);
  void HandleReply(class WireReader* reader, int64_t now_us, int64_t wall_us);

  const int64_t id_;
  const int total_;
  int64_t peer_ = 0;
  bool paired_ = false;
  int peer_total_ = 0;
  int peer_sent_ = 0;
  bool peer_final_ = false;
  bool final_ = false;
  int sent_ = 0;
  int64_t quiet_since_us_ = 0;  // nothing new was sent or arrived since
  int64_t last_heard_us_ = 0;
  std::array<uint32_t, kNumPlanes> received_{};
  std::array<uint32_t, kNumPlanes> peer_received_{};
  std::vector<bool> seen_;        // probes of the peer, by number
  std::vector<double> trips_us_;  // of our probes, by number; negative: not answered
  double fastest_us_ = 0;
  std::optional<double> clock_offset_us_;
};

}  // namespace cairn::deploy
