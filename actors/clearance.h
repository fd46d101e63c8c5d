#pragma once

#include "actors/scene.h"
#include "common/world/distance_field.h"
#include "common/world/obstacle_grid.h"

namespace cairn::actors {

/// The smaller of `upper` [m] and the distance from the footprint at `pose` to obstacles and bounds, never below 0.
/// Taken from the distance field along the footprint's edges, halved until two samples are `tolerance` = 1 mm ·
/// (half width / 25 mm) apart or the field's slope of 1 rules out anything below `upper`: its error is that tolerance
/// plus the field's own. An obstacle wholly inside the footprint is not seen; that is a collision anyway.
/// `center_distance` is the field at the pose's centre.
double FootprintClearance(const DistanceField& field, const Pose& pose, const Footprint& footprint,
                          double center_distance, double upper);

}  // namespace cairn::actors
