#pragma once

#include "actors/motion.h"
#include "common/world/distance_field.h"
#include "common/world/obstacle_grid.h"

namespace cairn::actors {

/// The smaller of `upper` [m] and the distance from the footprint at `pose` to obstacles and bounds, never below 0. For
/// a disc or sphere that is the field at its centre less the radius; a rectangle's is
/// taken from the distance field along the footprint's edges, which are halved until the field's slope of at most 1
/// leaves less than half of 0.08 · half_width (1 mm for the paper's car) to be found: its error is that plus the
/// field's own. An obstacle wholly inside the footprint is not seen; that is a collision anyway.
/// `center_distance` is the field at the pose's centre.
double FootprintClearance(const DistanceField& field, const Pose& pose, const Footprint& footprint,
                          double center_distance, double upper);

}  // namespace cairn::actors
