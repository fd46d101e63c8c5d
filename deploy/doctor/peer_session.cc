#include "deploy/doctor/peer_session.h"

#include <algorithm>
#include <numeric>

namespace cairn::deploy {

namespace {

constexpr uint32_t kMagic = 0x43445231;  // "CDR1"
constexpr int kMaxProbes = 10'000'000;
constexpr int64_t kQuietUs = 500'000;  // longer than any datagram is on its way

enum Kind : uint64_t { kState = 1, kProbe = 2, kReply = 3 };

// Numbers of eight bytes, big-endian.
void Put(uint64_t value, Bytes* out) {
  for (int shift = 56; shift >= 0; shift -= 8) out->push_back(static_cast<uint8_t>(value >> shift));
}

Bytes Begin(Kind kind, int64_t from, int64_t to) {
  Bytes out;
  for (const uint64_t value :
       {uint64_t{kMagic}, uint64_t{kind}, static_cast<uint64_t>(from), static_cast<uint64_t>(to)}) {
    Put(value, &out);
  }
  return out;
}

}  // namespace

// Reads them back; `ok` turns false at the end of the bytes.
class WireReader {
 public:
  explicit WireReader(ByteSpan bytes) : bytes_(bytes) {}
  uint64_t Get() {
    ok_ = ok_ && bytes_.size() >= 8;
    if (!ok_) return 0;
    uint64_t value = 0;
    for (int i = 0; i < 8; ++i) value = value << 8 | bytes_[static_cast<size_t>(i)];
    bytes_ = bytes_.subspan(8);
    return value;
  }
  // 0 … limit, else not ok.
  int GetCount(int limit) {
    const uint64_t value = Get();
    ok_ = ok_ && value <= static_cast<uint64_t>(limit);
    return ok_ ? static_cast<int>(value) : 0;
  }
  bool ok() const { return ok_; }

 private:
  ByteSpan bytes_;
  bool ok_ = true;
};

PeerSession::PeerSession(int64_t id, int probes)
    : id_(id), total_(probes), trips_us_(static_cast<size_t>(probes), -1.0) {}

std::optional<Bytes> PeerSession::Handle(ByteSpan datagram, int plane, int64_t now_us, int64_t wall_us) {
  WireReader reader(datagram);
  const bool ours = reader.Get() == kMagic;
  const uint64_t kind = reader.Get();
  const auto from = static_cast<int64_t>(reader.Get());
  const auto to = static_cast<int64_t>(reader.Get());
  // Our own words come back to us, and a third host may measure with another one.
  if (!ours || !reader.ok() || from == id_ || from == 0 || (to != 0 && to != id_)) return std::nullopt;
  if (peer_ == 0) peer_ = from;
  if (from != peer_) return std::nullopt;
  last_heard_us_ = now_us;
  paired_ = paired_ || to == id_;
  if (kind == kState) HandleState(&reader);
  if (kind == kReply) HandleReply(&reader, now_us, wall_us);
  if (kind != kProbe) return std::nullopt;
  quiet_since_us_ = now_us;
  return HandleProbe(&reader, plane, wall_us);
}

void PeerSession::HandleState(WireReader* reader) {
  const int total = reader->GetCount(kMaxProbes);
  const int sent = reader->GetCount(kMaxProbes);
  const bool is_final = reader->GetCount(1) == 1;
  std::array<uint32_t, kNumPlanes> received{};
  for (uint32_t& count : received) count = static_cast<uint32_t>(reader->GetCount(kMaxProbes));
  if (!reader->ok()) return;
  peer_total_ = total;
  peer_sent_ = std::max(peer_sent_, sent);
  peer_final_ = peer_final_ || is_final;
  // States may overtake each other; counts only grow.
  for (size_t i = 0; i < received.size(); ++i) peer_received_[i] = std::max(peer_received_[i], received[i]);
}

Bytes PeerSession::HandleProbe(WireReader* reader, int plane, int64_t wall_us) {
  const auto number = static_cast<size_t>(reader->GetCount(kMaxProbes - 1));
  const uint64_t sent_us = reader->Get();
  if (!reader->ok()) return {};
  if (seen_.size() <= number) seen_.resize(number + 1, false);
  if (!seen_[number]) ++received_[static_cast<size_t>(plane)];
  seen_[number] = true;
  Bytes reply = Begin(kReply, id_, peer_);
  for (const uint64_t value : {uint64_t{number}, sent_us, static_cast<uint64_t>(wall_us)}) Put(value, &reply);
  return reply;
}

void PeerSession::HandleReply(WireReader* reader, int64_t now_us, int64_t wall_us) {
  const auto number = static_cast<size_t>(reader->GetCount(total_ - 1));
  const auto sent_us = static_cast<int64_t>(reader->Get());
  const auto peer_wall_us = static_cast<int64_t>(reader->Get());
  if (!reader->ok() || trips_us_[number] >= 0 || sent_us > now_us) return;
  const auto trip = static_cast<double>(now_us - sent_us);
  trips_us_[number] = trip;
  if (clock_offset_us_ && trip >= fastest_us_) return;
  fastest_us_ = trip;
  clock_offset_us_ = static_cast<double>(peer_wall_us - wall_us) + trip / 2;
}

Bytes PeerSession::State() const {
  Bytes out = Begin(kState, id_, peer_);
  for (const uint64_t value : {static_cast<uint64_t>(total_), static_cast<uint64_t>(sent_), uint64_t{final_}}) {
    Put(value, &out);
  }
  for (const uint32_t count : received_) Put(count, &out);
  return out;
}

std::optional<Bytes> PeerSession::NextProbe(int64_t now_us) {
  if (!sending()) return std::nullopt;
  Bytes out = Begin(kProbe, id_, peer_);
  Put(static_cast<uint64_t>(sent_), &out);
  Put(static_cast<uint64_t>(now_us), &out);
  out.resize(kProbeBytes);
  ++sent_;
  quiet_since_us_ = now_us;
  return out;
}

void PeerSession::Tick(int64_t now_us) {
  const bool all_sent = sent_ == total_ && peer_total_ > 0 && peer_sent_ == peer_total_;
  final_ = final_ || (all_sent && now_us - quiet_since_us_ >= kQuietUs);
}

PeerResult PeerSession::Result() const {
  PeerResult result;
  result.probes = total_;
  for (size_t plane = 0; plane < kNumPlanes; ++plane) {
    result.sent_arrived[plane] = static_cast<int>(peer_received_[plane]);
    result.received[plane] = static_cast<int>(received_[plane]);
    result.probes_of_plane[plane] = (total_ + kNumPlanes - 1 - static_cast<int>(plane)) / kNumPlanes;
  }
  std::copy_if(trips_us_.begin(), trips_us_.end(), std::back_inserter(result.round_trips_us),
               [](double us) { return us >= 0; });
  std::sort(result.round_trips_us.begin(), result.round_trips_us.end());
  result.clock_offset_us = clock_offset_us_;
  return result;
}

namespace {

double LostShare(const std::array<int, kNumPlanes>& arrived, int sent) {
  return 1.0 - static_cast<double>(std::accumulate(arrived.begin(), arrived.end(), 0)) / sent;
}

}  // namespace

double PeerResult::lost_to_peer() const { return LostShare(sent_arrived, probes); }
double PeerResult::lost_from_peer() const { return LostShare(received, probes); }

double PeerResult::round_trip_us(double quantile) const {
  if (round_trips_us.empty()) return 0;
  const auto last = static_cast<double>(round_trips_us.size() - 1);
  return round_trips_us[static_cast<size_t>(quantile * last + 0.5)];
}

}  // namespace cairn::deploy
