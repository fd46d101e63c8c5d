#pragma once

namespace cairn::deploy {

/// CPUs this process may use, at least 1: the smallest of affinity, cgroup quota (v1 or v2) and Slurm's
/// SLURM_CPUS_PER_TASK.
int AvailableCpus();

/// Actors that fit beside one learner: AvailableCpus() − 1, but 2 on two CPUs, at most one per vehicle. On two CPUs the
/// learner leaves half of its core idle: with a second actor the car's maze took 29 s where one actor took 52 s.
int DefaultActors(int num_vehicles);

}  // namespace cairn::deploy
