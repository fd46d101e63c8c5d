#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/config/experiment.h"
#include "common/config/load.h"

namespace cairn::deploy {

/// What was typed after `cairn doctor`.
struct DoctorOptions {
  std::string subject;                 ///< run directory or experiment file; empty: the defaults
  std::vector<std::string> overrides;  ///< --set, of a file
  PlaceArguments place;                ///< --map, --robot, --goal, --start, of a file
  std::string lcm_url;                 ///< --lcm-url, as of cairn actor; empty: the subject's transport
  std::string key;                     ///< --key; empty: RUN_DIR/key, or `key` beside the file
  std::string run_dir;                 ///< --run-dir: where a run of the file would write; empty: here
  bool insecure = false;               ///< --insecure: do without a key though ttl ≥ 1
  bool json = false;
  bool peer = false;     ///< --peer: measure loss and round trip to a host that does the same
  int probes = 10000;    ///< --probes, each way
  double patience = 60;  ///< --timeout: how long to wait for the peer [s]
};

/// What the checks look at.
struct Subject {
  TransportConfig transport;
  bool from_defaults = false;  ///< neither run nor file nor URL was named
  std::string key_file;        ///< where the key is expected
  bool key_required = false;   ///< a missing one is a failure: it was named, or it is a run's
  bool insecure = false;
  std::string disk;        ///< directory on the disk to which the run writes; it exists
  int64_t disk_bytes = 0;  ///< that a run of this size writes
  std::string run_host;    ///< host on which the run was started; empty: unknown, or no run
  int64_t live_pid = 0;    ///< launcher of the run when it goes on here; else 0
};

/// Reads what was named, and enters the network of a run that goes on in a private one. Throws UsageError naming what
/// is wrong with it.
Subject FindSubject(const DoctorOptions& options);

}  // namespace cairn::deploy
