#include "common/config/conditions.h"

#include <google/protobuf/text_format.h>

#include <cmath>
#include <cstdlib>

#include "common/config/conditions.pb.h"
#include "common/config/parse_error.h"
#include "common/config/read_file.h"
#include "common/core/check.h"

namespace cairn {
namespace {

// "key=0.16R" with R in metres; everything else as it is.
std::string InMetres(const std::string& override, double radius) {
  const size_t equals = override.find('=');
  if (equals == std::string::npos || override.back() != 'R') return override;
  const std::string number = override.substr(equals + 1, override.size() - equals - 2);
  char* end = nullptr;
  const double value = std::strtod(number.c_str(), &end);
  if (number.empty() || *end != '\0') return override;
  return fmt::format("{}={}", override.substr(0, equals), value * radius);
}

template <typename List>
std::vector<std::string> InMetres(const List& overrides, double radius) {
  std::vector<std::string> converted;
  for (const std::string& override : overrides) converted.push_back(InMetres(override, radius));
  return converted;
}

proto::Conditions Parse(const std::string& path) {
  proto::Conditions message;
  config::FirstError collector;
  google::protobuf::TextFormat::Parser parser;
  parser.RecordErrorsTo(&collector);
  if (!parser.ParseFromString(config::ReadFileToText("--conditions", path), &message)) {
    ThrowUsageError("{}:{}: {}", path, collector.error().line + 1, collector.error().what);
  }
  return message;
}

}  // namespace

Conditions LoadConditions(const std::string& path, double radius) {
  const proto::Conditions message = Parse(path);
  Conditions conditions;
  conditions.trials = message.trials();
  if (conditions.trials < 1 || conditions.trials > 100000) {
    ThrowUsageError("{}: trials = {}; it must be in [1, 100000]", path, conditions.trials);
  }
  conditions.overrides = InMetres(message.set(), radius);
  for (const proto::Knob& knob : message.knob()) {
    if (knob.name().empty() || knob.point().empty()) {
      ThrowUsageError("{}: knob \"{}\": it needs a name and at least one point", path, knob.name());
    }
    conditions.knobs.push_back({knob.name(), knob.unit(), {}});
    for (const proto::ConditionPoint& point : knob.point()) {
      if (!point.has_value() || !std::isfinite(point.value())) {
        ThrowUsageError("{}: knob \"{}\": every point needs a finite value", path, knob.name());
      }
      conditions.knobs.back().points.push_back({point.value(), InMetres(point.set(), radius)});
    }
  }
  if (conditions.knobs.empty()) ThrowUsageError("{}: no knob; there must be at least one", path);
  return conditions;
}

}  // namespace cairn
