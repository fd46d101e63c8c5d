#include "common/core/check.h"
#include "common/process/process.h"
#include "learner/learner.h"

int main(int argc, char** argv) {
  return cairn::RunProcess(cairn::ProcessKind::kLearner, argc, argv, [](cairn::Process& process) {
    const cairn::ProcessOptions& options = process.options();
    cairn::Bus bus(process.MakeBusConfig());
    cairn::learner::Learner learner(
        &bus, process.experiment(),
        {options.run_dir, options.resume, options.actors, options.launch_utime_us, process.experiment_hash()});
    process.OnStop([&learner] { learner.RequestStop(); });
    learner.Run();
    process.OnStop([] {});
    if (!learner.completed()) cairn::ThrowError("stopped before the end of the run; the policy so far is saved");
  });
}
