#pragma once

#include "deploy/doctor/finding.h"
#include "deploy/doctor/subject.h"

namespace cairn::deploy {

/// Whether the run's five ports are free, or who has them. Call before sockets of one's own are bound to them.
Finding CheckPorts(const Subject& subject);

/// Whether the ttl fits who takes part: with 0 no other host must be among them.
Finding CheckTtl(const Subject& subject);

/// The key, where ttl ≥ 1 asks for one: there, sound, and closed to others.
Finding CheckKey(const Subject& subject);

/// What a process with ttl 0 and a peer on another host has to do.
Finding TtlForbidsPeer(const Subject& subject);

}  // namespace cairn::deploy
