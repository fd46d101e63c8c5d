#pragma once

#include "common/world/world.h"

namespace cairn {

/// The paper's quadrotor cube (Experimental Setup): `floors` of `rooms`² rooms, each floor a perfect maze with
/// `loop_fraction` of its remaining walls opened, where an opening is a square door in the middle of the wall; ceilings
/// are closed but for one shaft in the middle of one room's. The goal is the room of the top floor farthest (in doors)
/// from the shaft that leads there, starts are on the floors below. Lower corner at the origin, walls centred on the
/// lattice's lines; the bounds are the outer walls. Same seed, same boxes. Throws UsageError when a hole does not fit
/// its tile.
World MakeCubeMaze(const WorldConfig& config);

}  // namespace cairn
