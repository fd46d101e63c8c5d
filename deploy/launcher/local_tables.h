#pragma once

#include <memory>

#include "actors/course.h"
#include "common/config/experiment.h"

namespace cairn::deploy {

/// For goals = ANY and planner.repair: tables of any goal in the experiment's worlds, made in this process as the
/// planner makes them; those used last are kept, up to planner.table_cache_mb. From any thread. Throws UsageError for
/// what the planner refuses. Nothing where neither is asked for.
actors::Course::FindTable MakeLocalTables(const Experiment& experiment);

/// The course of a scene with a table, over such tables.
std::shared_ptr<actors::Course> MakeLocalCourse(const std::shared_ptr<const actors::Scene>& scene);

}  // namespace cairn::deploy
