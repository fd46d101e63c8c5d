#include "actors/actor.h"
#include "common/core/hash.h"
#include "common/core/log.h"
#include "common/process/process.h"

int main(int argc, char** argv) {
  return cairn::RunProcess(cairn::ProcessKind::kActor, argc, argv, [](cairn::Process& process) {
    const cairn::ProcessOptions& options = process.options();
    cairn::BusConfig config = process.MakeBusConfig();
    // Room for the sessions that this process may have to begin.
    for (int generation = options.generation * 1000;; ++generation, config.session = cairn::RandomId()) {
      cairn::Bus bus(config);
      cairn::actors::Actor actor(&bus, process.experiment(), {options.actor_id, generation, process.experiment_hash()});
      // Under a launcher the end of the run comes from there, and at once.
      if (options.parent_fd < 0) process.OnStop([&actor] { actor.RequestLeave(); });
      const cairn::actors::Actor::End end = actor.Run();
      process.OnStop({});
      if (end == cairn::actors::Actor::End::kFinished) return;
      cairn::log::Info("this session cannot go on; beginning a new one");
    }
  });
}
