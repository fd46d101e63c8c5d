#include "common/config/command_line.h"

#include <algorithm>

#include "common/config/nearest_name.h"
#include "common/core/check.h"

namespace cairn {
namespace {

// The command that was chosen, down to the last subcommand.
const CLI::App* Chosen(const CLI::App* app) {
  while (!app->get_subcommands().empty()) app = app->get_subcommands().front();
  return app;
}

// "cairn train": what is typed before --help.
std::string FullName(const CLI::App& app) {
  const CLI::App* parent = app.get_parent();
  return parent == nullptr ? app.get_name() : FullName(*parent) + " " + app.get_name();
}

std::vector<std::string> OptionNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

std::vector<std::string> CommandNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  return names;
}

[[noreturn]] void ThrowUnknown(const CLI::App& app, const std::string& word) {
  const CLI::App& chosen = *Chosen(&app);
  const bool option = word.size() > 1 && word[0] == '-';
  const std::string near = NearestName(word, option ? OptionNames(chosen) : CommandNames(chosen));
  ThrowUsageError("{} {}: unknown {}{}; see {} --help", chosen.get_name(), word, option ? "option" : "argument",
                  near.empty() ? "" : ", the nearest known one is " + near, FullName(chosen));
}

std::string OneLine(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (!text.empty() && (text.back() == ' ' || text.back() == '.')) text.pop_back();
  return text;
}

}  // namespace

bool ParseCommandLine(CLI::App* app, int argc, const char* const* argv) {
  try {
    app->parse(argc, argv);
    return true;
  } catch (const CLI::Success& asked) {
    app->exit(asked);
    return false;
  } catch (const CLI::ParseError& error) {
    // A mistyped command is reported as a missing one: the unknown word says more.
    const std::vector<std::string> extras = app->remaining(true);
    if (!extras.empty()) ThrowUnknown(*app, extras.front());
    const CLI::App& chosen = *Chosen(app);
    ThrowUsageError("{}: {}; see {} --help", chosen.get_name(), OneLine(error.what()), FullName(chosen));
  }
}

}  // namespace cairn
