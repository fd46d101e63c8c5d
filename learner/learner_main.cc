#include <filesystem>

#include "common/core/check.h"
#include "common/core/files.h"
#include "common/process/process.h"
#include "common/world/import/import_map.h"
#include "learner/learner.h"

namespace {

// `cairn train` has written it already. Of a learner that was started by hand the run directory is one as well, which
// can be evaluated and shown to the doctor.
void KeepExperiment(const cairn::Process& process) {
  const std::string& run_dir = process.options().run_dir;
  const std::string file = run_dir + "/experiment.textproto";
  if (run_dir.empty() || std::filesystem::exists(file)) return;
  std::filesystem::create_directories(run_dir);
  if (process.experiment().world.imported != nullptr) {
    std::filesystem::create_directories(run_dir + "/" + cairn::kMapFolder);
    cairn::CopyMap(process.experiment().world.map.file, run_dir + "/" + cairn::kMapFolder);
  }
  cairn::WriteFileAtomically(file, process.resolved_text());
}

}  // namespace

int main(int argc, char** argv) {
  return cairn::RunProcess(cairn::ProcessKind::kLearner, argc, argv, [](cairn::Process& process) {
    const cairn::ProcessOptions& options = process.options();
    KeepExperiment(process);
    cairn::Bus bus(process.MakeBusConfig());
    cairn::learner::LearnerOptions learner_options{options.run_dir, options.resume, options.actors,
                                                   options.launch_utime_us, process.experiment_hash()};
    learner_options.replay_log = options.replay_log;
    if (!options.replay_key.empty()) learner_options.replay_key = cairn::ReadKeyFile(options.replay_key);
    cairn::learner::Learner learner(&bus, process.experiment(), learner_options);
    process.OnStop([&learner] { learner.RequestStop(); });
    learner.Run();
    process.OnStop([] {});
    if (!learner.completed()) cairn::ThrowError("stopped before the end of the run; the policy so far is saved");
  });
}
