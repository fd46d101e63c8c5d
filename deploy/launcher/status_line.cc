#include "deploy/launcher/status_line.h"

#include <fmt/core.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

namespace cairn::deploy {
namespace {

std::string Grouped(int64_t value) {
  std::string digits = std::to_string(value);
  for (int at = static_cast<int>(digits.size()) - 3; at > (value < 0 ? 1 : 0); at -= 3)
    digits.insert(static_cast<size_t>(at), 1, ',');
  return digits;
}

std::string Time(double seconds) {
  const auto s = static_cast<int64_t>(std::ceil(seconds));
  if (s < 3600) return fmt::format("{}:{:02}", s / 60, s % 60);
  return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

std::string Eta(const RunStatus& status) {
  const double left = static_cast<double>(std::max<int64_t>(0, status.total_env_steps - status.env_steps));
  if (left == 0) return "";
  const double seconds = left / status.env_steps_per_s;
  return std::isfinite(seconds) && seconds < 1e8 ? fmt::format("  ETA {}", Time(seconds)) : "  ETA -";
}

int Columns(FILE* out) {
  winsize size{};
  return ioctl(fileno(out), TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

}  // namespace

std::string FormatStatus(const RunStatus& status) {
  const double share = status.total_env_steps > 0
                           ? 100.0 * static_cast<double>(status.env_steps) / static_cast<double>(status.total_env_steps)
                           : 0.0;
  const std::string success = status.success_rate < 0 ? "-" : fmt::format("{:.1f} %", 100.0 * status.success_rate);
  const std::string consumption = status.consumption_env_steps < 0 ? "-" : Grouped(status.consumption_env_steps);
  return fmt::format("{}  {} / {}  {:.0f} %  {} steps/s  {} updates/s  success {}  consumption {}{}{}", status.phase,
                     Grouped(status.env_steps), Grouped(status.total_env_steps), std::floor(share),
                     Grouped(std::llround(status.env_steps_per_s)), Grouped(std::llround(status.updates_per_s)),
                     success, consumption, Eta(status), status.warning.empty() ? "" : "  ! " + status.warning);
}

StatusLine::Mode StatusLine::ModeFor(FILE* out, bool quiet) {
  if (quiet) return Mode::kQuiet;
  return isatty(fileno(out)) == 1 ? Mode::kTerminal : Mode::kPlain;
}

StatusLine::StatusLine(FILE* out, Mode mode, Duration plain_period)
    : out_(out), mode_(mode), plain_period_(plain_period), next_plain_(Clock::now()) {}

StatusLine::~StatusLine() { Finish(); }

// A reader that goes away (`cairn train … | head`) ends the line, not the run.
void StatusLine::Print(const std::string& text) {
  if (mode_ == Mode::kQuiet) return;
  const bool written = std::fputs(text.c_str(), out_) >= 0 && std::fflush(out_) == 0;
  if (written) return;
  mode_ = Mode::kQuiet;
  std::clearerr(out_);
}

void StatusLine::Update(const RunStatus& status) {
  const std::string line = FormatStatus(status);
  if (mode_ == Mode::kQuiet || line == last_) return;
  last_ = line;
  pending_ = true;
  if (mode_ == Mode::kTerminal) return Rewrite(line.substr(0, static_cast<size_t>(Columns(out_)) - 1));
  if (Clock::now() < next_plain_) return;
  next_plain_ = Clock::now() + plain_period_;
  Print(line + "\n");
  pending_ = false;
}

void StatusLine::Note(const std::string& line) {
  if (mode_ == Mode::kQuiet) return;
  Clear();
  Print(line + "\n");
  if (mode_ == Mode::kTerminal && !last_.empty()) Rewrite(last_.substr(0, static_cast<size_t>(Columns(out_)) - 1));
}

void StatusLine::Finish() {
  if (pending_) {
    Clear();
    Print(last_ + "\n");
  }
  pending_ = false;
  last_.clear();  // a later note stands alone
}

void StatusLine::Rewrite(const std::string& line) {
  Print("\r\x1b[K" + line);
  shown_ = true;
}

void StatusLine::Clear() {
  if (shown_) Print("\r\x1b[K");
  shown_ = false;
}

}  // namespace cairn::deploy
