#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace cairn::deploy {

/// What was typed after `cairn eval`.
struct EvalOptions {
  std::string run_dir;
  int trials = 0;                      ///< test starts 0 … trials − 1; 0: evaluation.test_starts
  std::optional<uint64_t> seed;        ///< of the disturbances; left out: the run's
  std::string controller;              ///< policy or pure_pursuit; empty: the policy, with conditions both
  std::string policy;                  ///< best or last; empty: the best if there is one, else the last
  std::vector<std::string> overrides;  ///< of the run's experiment, as typed after --set
  std::string conditions;              ///< file of conditions to drive one after the other; empty: none
  std::string svg;                     ///< picture of the driven paths, with conditions of success; empty: none
  std::string html;                    ///< interactive page of the driven paths; empty: none
  std::string q_map;                   ///< picture of what the critics expect; empty: none
  std::string score_map;               ///< picture of how soon the goal is reached from everywhere; empty: none
  std::optional<double> height;        ///< of the maps' slice through a world in space [m]; left out: the middle
  bool json = false;
};

/// Drives the test starts of a run's world with its policy, or with pure pursuit on a roadmap of its own, and prints
/// what came of it; or does so under each of many conditions. Returns 0 whatever the success; throws UsageError or
/// Error.
int Eval(const EvalOptions& options);

}  // namespace cairn::deploy
