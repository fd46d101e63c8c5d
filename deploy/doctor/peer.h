#pragma once

#include <optional>
#include <vector>

#include "deploy/doctor/finding.h"
#include "deploy/doctor/peer_session.h"
#include "deploy/doctor/subject.h"

namespace cairn::deploy {

struct PeerReport {
  std::vector<Finding> findings;
  std::string address;               ///< of the peer; empty: none found
  std::optional<PeerResult> result;  ///< when the measurement came to its end
};

/// Waits for another host that runs `cairn doctor --peer` on the same group and ports, and measures with it: loss each
/// way and round trip, over all planes' ports, with datagrams as large as messages between hosts. Takes about 6 s for
/// 10,000 probes.
PeerReport MeasurePeer(const Subject& subject, int probes, double patience_s);

}  // namespace cairn::deploy
