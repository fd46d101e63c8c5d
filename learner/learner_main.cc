#include <filesystem>

#include "common/core/check.h"
#include "common/core/files.h"
#include "common/process/process.h"
#include "common/world/import/import_map.h"
#include "learner/learner.h"

namespace {

namespace fs = std::filesystem;

// A learner that was started by hand without --resume would begin anew over what is there.
void CheckVacant(const cairn::ProcessOptions& options) {
  if (options.run_dir.empty() || options.resume) return;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(options.run_dir + "/checkpoints", ignored)) {
    if (entry.path().extension() != ".ckpt") continue;
    cairn::ThrowUsageError("--run-dir {}: it holds checkpoints of a run; --resume goes on with it, or give another one",
                           options.run_dir);
  }
}

// `cairn train` has written it already. Of a learner that was started by hand the run directory is one as well, which
// can be evaluated and shown to the doctor.
void KeepExperiment(const cairn::Process& process) {
  const std::string& run_dir = process.options().run_dir;
  const std::string file = run_dir + "/experiment.textproto";
  if (run_dir.empty() || fs::exists(file)) return;
  fs::create_directories(run_dir);
  const cairn::Experiment& experiment = process.experiment();
  if (experiment.world.imported != nullptr) {
    fs::create_directories(run_dir + "/" + cairn::kMapFolder);
    cairn::CopyMap(experiment.world.map.file, run_dir + "/" + cairn::kMapFolder);
  }
  if (const std::string& roadmap = experiment.planner.roadmap; !roadmap.empty()) {
    const std::string folder = run_dir + "/" + cairn::kRoadmapFolder + "/";
    fs::create_directories(folder);
    cairn::WriteFileAtomically(folder + fs::path(roadmap).filename().string(), cairn::ReadFile(roadmap));
  }
  cairn::WriteFileAtomically(file, process.resolved_text());
}

}  // namespace

int main(int argc, char** argv) {
  return cairn::RunProcess(cairn::ProcessKind::kLearner, argc, argv, [](cairn::Process& process) {
    const cairn::ProcessOptions& options = process.options();
    CheckVacant(options);
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
