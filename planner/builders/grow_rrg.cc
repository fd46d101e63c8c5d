#include <ompl/base/PlannerTerminationCondition.h>

#include "planner/builders/builder.h"
#include "planner/builders/coverage.h"
#include "planner/builders/rrg.h"
#include "planner/collision/ompl_space.h"

namespace cairn::planner {

Grown GrowRrg(const BuildTask& task) {
  const PlannerConfig& config = task.config;
  Coverage coverage(task.space, config.r_ball(), kCoverageSamples, config.seed);
  const ompl::base::SpaceInformationPtr information = MakeSpaceInformation(task.space, config.seed);
  Rrg rrg(information);
  rrg.SetEta(config.eta);
  rrg.SetMinSpacing(config.min_spacing);
  rrg.SetVertexObserver([&](const Vector3d& p) { coverage.AddVertex(p); });
  rrg.setProblemDefinition(MakeProblem(information, ChooseRoots(task),
                                       MakeRegionGoal(information, task.space.world(), task.space.world().start)));
  rrg.setup();
  // The graph grows on samples of its own; every vertex hangs on a root in the goal region, so what is covered is
  // connected to the goal.
  const auto done = [&] { return coverage.share() >= config.coverage || rrg.num_samples() >= config.max_samples; };
  rrg.solve(ompl::base::PlannerTerminationCondition(done));
  const double share = coverage.share();
  if (share < config.coverage) ThrowSampleCap(config, share);
  rrg.ConnectPassages(coverage.samples(), 2 * config.r_ball());
  return {rrg.roadmap(), rrg.num_samples(), share};
}

}  // namespace cairn::planner
