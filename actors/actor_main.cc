#include <unistd.h>

#include "actors/actor.h"
#include "common/process/process.h"

int main(int argc, char** argv) {
  return cairn::RunProcess(cairn::ProcessKind::kActor, argc, argv, [](cairn::Process& process) {
    const cairn::ProcessOptions& options = process.options();
    cairn::Bus bus(process.MakeBusConfig());
    cairn::actors::Actor actor(&bus, process.experiment(),
                               {options.actor_id, options.generation, process.experiment_hash()});
    actor.Run();
  });
}
