#include <atomic>

#include "common/core/log.h"
#include "common/process/process.h"
#include "common/world/world_variants.h"
#include "planner/planner.h"
#include "planner/roadmap_service.h"

int main(int argc, char** argv) {
  return cairn::RunProcess(cairn::ProcessKind::kPlanner, argc, argv, [](cairn::Process& process) {
    const cairn::Experiment& experiment = process.experiment();
    const cairn::World world = cairn::MakeWorldVariants(experiment).known;
    const cairn::DistanceField field(world, experiment.world.field_resolution);
    const cairn::planner::BuiltRoadmap built =
        cairn::planner::BuildRoadmap(world, field, experiment.planner, experiment.vehicle.inscribed_radius());
    cairn::log::Info("roadmap: {} vertices, {} edges, coverage {:.4f}, {:.3f} s", built.info.vertices, built.info.edges,
                     built.info.coverage, built.info.build_s);
    cairn::Bus bus(process.MakeBusConfig());
    std::atomic<bool> stop{false};
    process.OnStop([&stop] { stop = true; });
    cairn::planner::RoadmapService service(&bus, process.experiment_hash(), built,
                                           cairn::planner::ComputeCostTable(built.roadmap, world, world.goal));
    service.Run([&stop] { return stop.load(); });
  });
}
