#include <atomic>

#include "common/process/process.h"
#include "planner/roadmap_service.h"

int main(int argc, char** argv) {
  return cairn::RunProcess(cairn::ProcessKind::kPlanner, argc, argv, [](cairn::Process& process) {
    const cairn::Experiment& experiment = process.experiment();
    cairn::Bus bus(process.MakeBusConfig());
    std::atomic<bool> stop{false};
    process.OnStop([&stop] { stop = true; });
    cairn::planner::RoadmapService service(&bus, process.experiment_hash(), experiment);
    service.Run([&stop] { return stop.load(); });
  });
}
