#include "deploy/doctor/doctor.h"

#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/core/check.h"
#include "deploy/doctor/finding.h"
#include "deploy/doctor/host_checks.h"
#include "deploy/doctor/network_checks.h"
#include "deploy/doctor/peer.h"
#include "deploy/doctor/run_checks.h"

namespace cairn::deploy {
namespace {

const char* StateName(FindingState state) {
  switch (state) {
    case FindingState::kOk:
      return "ok";
    case FindingState::kWarn:
      return "warn";
    case FindingState::kFail:
      return "fail";
  }
  return "";
}

// Prints each finding as it is made, or keeps it for the JSON object at the end.
class Report {
 public:
  explicit Report(bool json) : print_(!json) {}

  void Add(const Finding& finding) {
    findings_.push_back(finding);
    if (!print_) return;
    const std::string cure = finding.cure.empty() ? "" : "; cure: " + finding.cure;
    fmt::print("{:<5}{}: {}{}\n", StateName(finding.state), finding.name, finding.detail, cure);
    std::fflush(stdout);
  }

  int Count(FindingState state) const {
    return static_cast<int>(std::count_if(findings_.begin(), findings_.end(),
                                          [state](const Finding& finding) { return finding.state == state; }));
  }

  void Finish(const PeerReport& peer) const {
    if (print_) {
      fmt::print("{} ok, {} warnings, {} failures\n", Count(FindingState::kOk), Count(FindingState::kWarn),
                 Count(FindingState::kFail));
    } else {
      fmt::print("{}\n", ToJson(peer).dump(2));
    }
  }

 private:
  nlohmann::ordered_json ToJson(const PeerReport& peer) const {
    nlohmann::ordered_json json;
    json["failures"] = Count(FindingState::kFail);
    json["warnings"] = Count(FindingState::kWarn);
    for (const Finding& finding : findings_) {
      json["checks"].push_back({{"name", finding.name},
                                {"state", StateName(finding.state)},
                                {"detail", finding.detail},
                                {"cure", finding.cure}});
    }
    if (!peer.result) return json;
    json["peer"] = {{"address", peer.address},
                    {"probes", peer.result->probes},
                    {"lost_to_peer", peer.result->lost_to_peer()},
                    {"lost_from_peer", peer.result->lost_from_peer()},
                    {"round_trip_median_us", peer.result->round_trip_us(0.5)},
                    {"round_trip_p99_us", peer.result->round_trip_us(0.99)},
                    {"clock_offset_us", peer.result->clock_offset_us.value_or(0)}};
    return json;
  }

  bool print_;
  std::vector<Finding> findings_;
};

void LookAtHost(const Subject& subject, Report* report) {
  report->Add(CheckCpu(subject));
  report->Add(CheckClock());
  report->Add(CheckDisk(subject));
  report->Add(CheckReceiveBuffer());
}

void LookAtNetwork(const Subject& subject, Report* report) {
  if (!subject.transport.broker.empty()) return report->Add(CheckBroker(subject));
  // The route first: where there is none, a private network is what the other lines are about.
  const Finding route = CheckRoute(subject);
  report->Add(route);
  report->Add(CheckLoopback());
  report->Add(CheckFragments(subject));
  report->Add(CheckPorts(subject));
  if (route.state != FindingState::kFail) report->Add(CheckEcho(subject));
}

}  // namespace

int Doctor(const DoctorOptions& options) {
  Subject subject = FindSubject(options);
  // The defaults stay on one host, and who names no run but a peer means two.
  if (options.peer && subject.from_defaults) subject.transport.ttl = 1;
  if (options.peer && !subject.transport.broker.empty()) {
    ThrowUsageError("--peer: it measures multicast, and this run's messages go over the broker at tcpq://{}",
                    subject.transport.broker);
  }
  const bool measure = options.peer && subject.transport.ttl > 0;
  Report report(options.json);
  LookAtHost(subject, &report);
  LookAtNetwork(subject, &report);
  report.Add(options.peer && !measure ? TtlForbidsPeer(subject) : CheckTtl(subject));
  // A measurement between hosts alone needs no key.
  if (!(options.peer && subject.from_defaults)) report.Add(CheckKey(subject));
  PeerReport peer;
  if (measure) peer = MeasurePeer(subject, options.probes, options.patience);
  for (const Finding& finding : peer.findings) report.Add(finding);
  report.Finish(peer);
  return report.Count(FindingState::kFail) > 0 ? 1 : 0;
}

}  // namespace cairn::deploy
