#pragma once

#include "deploy/doctor/finding.h"
#include "deploy/doctor/subject.h"

namespace cairn::deploy {

/// What the kernel gives of the receive buffer that the planes ask for.
Finding CheckReceiveBuffer();

/// Clock source, cost of a reading, whether the wall clock is kept right.
Finding CheckClock();

/// Processors and the instruction sets that matter: of matrix products, and AES where the run needs a key.
Finding CheckCpu(const Subject& subject);

/// Whether a run of this size fits on its disk, by what is free and by writing a little.
Finding CheckDisk(const Subject& subject);

}  // namespace cairn::deploy
