#pragma once

#include "deploy/doctor/subject.h"

namespace cairn::deploy {

/// `cairn doctor`: looks at everything that Cairn needs of this host and prints a line for each: ok, warn or fail, what
/// was seen, the cure. With `peer` it then measures loss and round trip to a host that does the same. Returns 1 when
/// something failed, else 0. Throws UsageError for what was typed.
int Doctor(const DoctorOptions& options);

}  // namespace cairn::deploy
