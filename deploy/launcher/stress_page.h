#pragma once

#include "common/config/load.h"
#include "deploy/launcher/eval.h"
#include "deploy/launcher/run_directory.h"

namespace cairn::deploy {

/// `cairn eval --conditions`: drives the test starts of the run, whose experiment is `own`, under each condition of a
/// file with its policy and with pure pursuit, prints a table or JSON and draws the picture that was asked for. Returns
/// 0; throws as Eval does.
int DriveConditions(const EvalOptions& options, const RunDirectory& run, const LoadedExperiment& own);

}  // namespace cairn::deploy
