#pragma once

#include "deploy/doctor/finding.h"
#include "deploy/doctor/subject.h"

namespace cairn::deploy {

/// The loopback interface: the guard of a run's ports, and all of a run with ttl 0, live on it.
Finding CheckLoopback();

/// The way to the group: whether there is one, and with ttl ≥ 1 whether it leads out of this host. Where `cairn train`
/// would make a private network because there is none, this process enters one, so that later checks see what it sees.
Finding CheckRoute(const Subject& subject);

/// Whether messages are cut in IP fragments on the way, and what the kernel has for putting them together.
Finding CheckFragments(const Subject& subject);

/// Sends each plane's largest message to the group and waits for it on this host. When it does not come back: at which
/// step it stops.
Finding CheckEcho(const Subject& subject);

/// The brokers of a run whose messages go over LCM's broker instead of multicast.
Finding CheckBroker(const Subject& subject);

/// What lets UDP ports [first, last] pass a firewall.
std::string FirewallCure(int first, int last);

}  // namespace cairn::deploy
