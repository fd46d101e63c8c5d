#include "learner/logged_experience.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/bus/bus.h"
#include "common/core/check.h"
#include "common/core/log.h"

namespace cairn::learner {
namespace {

// A message that others of its stream overtake is sent again long before so many more have come.
constexpr size_t kMaxEarly = 512;
constexpr std::string_view kExperiencePrefix = "CAIRN_EXP_";

bool IsExperience(const LoggedMessage& message) {
  return message.channel.compare(0, kExperiencePrefix.size(), kExperiencePrefix) == 0;
}

bool AllFinite(const Segment& segment) {
  const auto finite = [](const std::vector<float>& values) {
    return std::all_of(values.begin(), values.end(), [](float x) { return std::isfinite(x); });
  };
  return finite(segment.observations) && finite(segment.actions) && finite(segment.rewards);
}

}  // namespace

std::string LogCounters::Trouble() const {
  std::string text;
  const auto add = [&text](int64_t count, const char* what) {
    if (count > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, what);
  };
  add(faults, "places that are no message");
  add(frames_refused, "frames refused");
  add(messages_missing, "messages of streams missing");
  add(transitions_duplicate, "transitions twice");
  add(transitions_not_finite, "transitions not finite");
  return text;
}

LoggedExperience::LoggedExperience(const std::string& file, const std::optional<RunKey>& key, const Shape& shape)
    : reader_(file), shape_(shape) {
  CheckBeginning(file, key, shape);
}

// Finds the run that the log is of, by the first experience that opens; frames of others are refused from then on.
void LoggedExperience::CheckBeginning(const std::string& file, const std::optional<RunKey>& key, const Shape& shape) {
  LogReader look(file);
  std::optional<FrameFault> fault;
  int64_t hash = 0;
  while (const std::optional<LoggedMessage> message = look.Next()) {
    const std::optional<int64_t> run_id = FrameRunId(ByteSpan(message->bytes));
    if (!run_id) continue;
    const FrameSeal seal(*run_id, key);
    const bool experience = IsExperience(*message);
    if (!experience && message->channel != kHelloChannel) continue;
    const OpenedFrame opened = seal.Open(Plane::kExperience, ByteSpan(message->bytes), nullptr);
    if (opened.fault) {
      fault = opened.fault;
      continue;
    }
    if (!experience) {
      if (const auto hello = Decode<Hello>(opened.message)) hash = static_cast<int64_t>(hello->experiment_hash);
      continue;
    }
    const std::optional<Experience> first = Decode<Experience>(opened.message);
    if (!first) continue;
    if (first->observation_size != shape.observation_size || first->action_size != shape.action_size) {
      ThrowUsageError(
          "--replay-log {}: it was recorded from another experiment: observation_size {} (here {}), action_size {} "
          "(here {})",
          file, first->observation_size, shape.observation_size, first->action_size, shape.action_size);
    }
    if (hash != 0 && hash != static_cast<int64_t>(shape.experiment_hash)) {
      log::Warning("--replay-log {}: recorded from an experiment of the same sizes that differs in something else",
                   file);
    }
    seal_.emplace(*run_id, key);
    return;
  }
  const char* why = "it holds no experience; was the experience plane recorded?";
  if (fault == FrameFault::kKeyed) why = "its messages are sealed with a key; give --replay-key FILE";
  if (fault == FrameFault::kNoKey) why = "its messages are not sealed; leave out --replay-key";
  if (fault == FrameFault::kTag) why = "its messages are sealed with another key than --replay-key";
  if (fault == FrameFault::kProtocol) why = "it was recorded from a Cairn with another protocol";
  ThrowUsageError("--replay-log {}: {}", file, why);
}

std::optional<Harvest> LoggedExperience::Next() {
  std::optional<Experience> experience = NextExperience();
  counters_.faults = reader_.faults();
  if (!experience) return std::nullopt;
  ++counters_.messages;
  return Judge(std::move(*experience));
}

std::optional<Experience> LoggedExperience::NextExperience() {
  while (ready_.empty() && !ended_) {
    if (std::optional<Experience> read = ReadExperience()) {
      Accept(std::move(*read));
      continue;
    }
    ended_ = true;
    for (auto& [session, stream] : streams_) {
      while (const int64_t missing = stream.SkipGap()) {
        counters_.messages_missing += missing;
        while (std::optional<Experience> next = stream.Take()) ready_.push_back(std::move(*next));
      }
    }
  }
  if (ready_.empty()) return std::nullopt;
  Experience first = std::move(ready_.front());
  ready_.pop_front();
  return first;
}

std::optional<Experience> LoggedExperience::ReadExperience() {
  while (const std::optional<LoggedMessage> message = reader_.Next()) {
    if (!IsExperience(*message)) continue;
    const OpenedFrame opened = seal_->Open(Plane::kExperience, ByteSpan(message->bytes), &peers_);
    std::optional<Experience> experience;
    if (!opened.fault) experience = Decode<Experience>(opened.message);
    if (experience && experience->observation_size == shape_.observation_size &&
        experience->action_size == shape_.action_size) {
      return experience;
    }
    ++counters_.frames_refused;
  }
  return std::nullopt;
}

// A log may begin in the middle of a stream.
void LoggedExperience::Accept(Experience experience) {
  ReliableReceiver<Experience>& stream =
      streams_.try_emplace(experience.session, experience.sequence - 1).first->second;
  const int64_t sequence = experience.sequence;
  stream.Accept(sequence, std::move(experience));
  if (stream.num_early() > kMaxEarly) counters_.messages_missing += stream.SkipGap();
  while (std::optional<Experience> next = stream.Take()) ready_.push_back(std::move(*next));
}

Harvest LoggedExperience::Judge(Experience experience) {
  Harvest harvest;
  for (const EpisodeResult& episode : experience.episodes) {
    if (episode.set == StartSet::kTraining) harvest.episodes.push_back(episode);
  }
  for (Segment& segment : experience.segments) {
    Trajectory& vehicle = vehicles_[segment.vehicle];
    const bool behind = segment.episode < vehicle.episode ||
                        (segment.episode == vehicle.episode && segment.first_step < vehicle.next_step);
    if (behind) {
      counters_.transitions_duplicate += segment.num_steps();
    } else if (!AllFinite(segment)) {
      counters_.transitions_not_finite += segment.num_steps();
    } else {
      vehicle = {segment.episode, segment.first_step + segment.num_steps()};
      counters_.transitions += segment.num_steps();
      harvest.segments.push_back(std::move(segment));
    }
  }
  return harvest;
}

}  // namespace cairn::learner
