#pragma once

namespace cairn::deploy {

/// CPUs this process may use, at least 1: the smallest of affinity, cgroup quota (v1 or v2) and Slurm's
/// SLURM_CPUS_PER_TASK.
int AvailableCpus();

/// Actors that fit beside one learner: AvailableCpus() − 1, at least 1, at most one per vehicle.
int DefaultActors(int num_vehicles);

}  // namespace cairn::deploy
