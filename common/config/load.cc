#include "common/config/load.h"

#include <google/protobuf/text_format.h>

#include <filesystem>

#include "common/config/arguments.h"
#include "common/config/draft.h"
#include "common/config/from_proto.h"
#include "common/config/map.h"
#include "common/config/override.h"
#include "common/config/ranges.h"
#include "common/config/read_file.h"
#include "common/config/resolve.h"
#include "common/config/roadmap_path.h"
#include "common/config/rules.h"
#include "common/config/text_reader.h"
#include "common/core/check.h"
#include "common/core/hash.h"

namespace cairn {
namespace {

std::string Print(const proto::Experiment& message) {
  std::string text;
  google::protobuf::TextFormat::Printer printer;
  printer.SetUseShortRepeatedPrimitives(true);
  CAIRN_CHECK(printer.PrintToString(message, &text));
  return text;
}

// Name and transport may differ between the processes of one run and between a run and its repetition.
uint64_t Hash(proto::Experiment message) {
  message.clear_name();
  message.clear_transport();
  message.mutable_world()->clear_map();
  message.mutable_planner()->clear_roadmap();
  const std::string text = Print(message);
  return ContentHash(text.data(), text.size());
}

}  // namespace

LoadedExperiment ParseExperiment(const std::string& text, const std::string& source,
                                 const std::vector<std::string>& overrides, const PlaceArguments& arguments) {
  config::Draft draft = config::ReadText(text, source);
  if (!arguments.robot.empty()) {
    config::ReadVehicle(config::ReadFileToText("--robot", arguments.robot), arguments.robot, &draft);
  }
  config::ApplyArguments(arguments, &draft);
  for (const std::string& assignment : overrides) config::ApplyOverride(assignment, &draft);
  config::CheckRanges(draft);  // before deriving, so that the typed value is named and not what followed from it
  const std::string directory = std::filesystem::path(source).parent_path().string();
  const config::ReadMapResult read = config::ReadMap(directory, &draft);
  const std::string roadmap = config::FindRoadmap(directory, &draft);
  config::Resolve(&draft, read.map.get());
  config::CheckRanges(draft);
  config::CheckRules(draft);
  LoadedExperiment loaded{config::FromProto(draft.message), Print(draft.message), Hash(draft.message)};
  loaded.experiment.world.map.file = read.file;
  loaded.experiment.world.imported = read.map;
  loaded.experiment.planner.roadmap = roadmap;
  return loaded;
}

LoadedExperiment LoadExperiment(const std::string& path, const std::vector<std::string>& overrides,
                                const PlaceArguments& arguments) {
  return ParseExperiment(config::ReadFileToText("experiment file", path), path, overrides, arguments);
}

}  // namespace cairn
