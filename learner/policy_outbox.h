#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "common/bus/bus.h"

namespace cairn::learner {

/// The policies that actors may still ask for, sent in chunks: once when they are new, and again to whoever lacks one.
/// Plain bookkeeping; the Coordinator locks around it.
class PolicyOutbox {
 public:
  PolicyOutbox(Bus* bus, int64_t incarnation) : bus_(bus), incarnation_(incarnation) {}

  /// Keeps and sends a version; one that is here already changes nothing.
  void Add(int64_t version, std::span<const float> parameters);

  /// Parameters of a version that is kept; empty when it is not.
  std::vector<float> Find(int64_t version) const;

  /// An actor lacks a version: sends it again, unless that was done a moment ago for another.
  void Resend(int64_t version, TimePoint now);

  /// Drops the oldest versions beyond a few, except those that `in_use` names.
  void DropUnused(const std::function<bool(int64_t version)>& in_use);

 private:
  struct Entry {
    std::vector<float> parameters;
    TimePoint sent_at{};
  };
  void Send(int64_t version, Entry* entry);

  Bus* bus_;
  int64_t incarnation_;
  std::map<int64_t, Entry> policies_;
};

}  // namespace cairn::learner
