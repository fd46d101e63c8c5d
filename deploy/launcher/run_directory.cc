#include "deploy/launcher/run_directory.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <vector>

#include "common/config/lcm_url.h"
#include "common/core/check.h"
#include "common/core/files.h"
#include "common/core/version.h"
#include "common/world/import/import_map.h"

namespace cairn::deploy {
namespace {

namespace fs = std::filesystem;

// Any of these means that another run lives or lived here.
constexpr const char* kRunFiles[] = {"experiment.textproto", "run.json",    "summary.json",
                                     "episodes.csv",         "checkpoints", "key"};

std::string DefaultPath(const std::string& name) {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  char date[32];
  std::strftime(date, sizeof(date), "%Y%m%d-%H%M%S", &local);
  const std::string base = fmt::format("runs/{}-{}", name, date);
  std::string path = base;
  for (int i = 2; fs::exists(path); ++i) path = fmt::format("{}-{}", base, i);
  return path;
}

// Removes what was made here when the creation does not succeed.
class Undo {
 public:
  ~Undo() {
    std::error_code ignored;
    if (!tree_.empty()) fs::remove_all(tree_, ignored);
    for (auto it = made_.rbegin(); it != made_.rend(); ++it) fs::remove(*it, ignored);  // a directory only when empty
  }
  void Made(const fs::path& path) { made_.push_back(path); }
  void MadeTree(const fs::path& path) { tree_ = path; }
  void Keep() {
    made_.clear();
    tree_.clear();
  }

 private:
  std::vector<fs::path> made_;
  fs::path tree_;
};

// Makes one directory; false when there is one already.
bool MakeDirectory(const fs::path& path, Undo* undo) {
  if (mkdir(path.c_str(), 0777) == 0) {
    undo->Made(path);
    return true;
  }
  const int error = errno;
  if (error == EEXIST && fs::is_directory(path)) return false;
  ThrowError("run directory {}: {}", path.string(), std::strerror(error));
}

void MakeParents(const fs::path& path, Undo* undo) {
  if (path.empty() || fs::is_directory(path)) return;
  MakeParents(path.parent_path(), undo);
  MakeDirectory(path, undo);
}

[[noreturn]] void ThrowTaken(const std::string& path, const std::string& what) {
  ThrowUsageError("--run-dir {}: it already holds a run ({}); give another directory", path, what);
}

// Whether a process runs the `cairn` command, whatever the link by which it was called; of another user's process only
// the name is known.
bool IsCairn(int64_t pid) {
  std::error_code error;
  const fs::path program = fs::read_symlink(fmt::format("/proc/{}/exe", pid), error);
  if (!error) {
    const std::string name = program.filename();  // "cairn (deleted)" once it was built anew
    return name == "cairn" || name == "cairn (deleted)";
  }
  std::ifstream file(fmt::format("/proc/{}/comm", pid));
  std::string name;
  return std::getline(file, name) && name == "cairn";
}

TransportConfig TransportOf(const BusConfig& bus) {
  return {bus.group, bus.base_port, bus.ttl, bus.broker, bus.telemetry_broker};
}

template <typename T>
T Get(const nlohmann::json& json, const char* key) {
  return json.at(key).get<T>();
}

}  // namespace

RunDirectory RunDirectory::Create(const std::string& path, const std::string& name, const std::string& resolved_text,
                                  const std::string& map_file, const std::string& roadmap_file) {
  RunDirectory directory(fs::absolute(path.empty() ? DefaultPath(name) : path).lexically_normal().string());
  while (directory.path_.size() > 1 && directory.path_.back() == '/') directory.path_.pop_back();
  CheckVacant(directory.path_);
  if (IsVoid(directory.path_)) SetAside(directory.path_);
  Undo undo;
  MakeParents(directory.path_, &undo);
  // Whoever makes this one owns the run, should two start at the same moment.
  if (!MakeDirectory(directory.path_ + "/checkpoints", &undo)) ThrowTaken(directory.path_, "checkpoints");
  MakeDirectory(directory.path_ + "/log", &undo);
  if (!map_file.empty()) {
    if (!MakeDirectory(directory.map_folder(), &undo)) ThrowTaken(directory.path_, kMapFolder);
    undo.MadeTree(directory.map_folder());
    CopyMap(map_file, directory.map_folder());
  }
  if (!roadmap_file.empty()) {
    if (!MakeDirectory(directory.roadmap_folder(), &undo)) ThrowTaken(directory.path_, kRoadmapFolder);
    undo.MadeTree(directory.roadmap_folder());
    WriteFileAtomically(directory.roadmap_folder() + "/" + fs::path(roadmap_file).filename().string(),
                        ReadFile(roadmap_file));
  }
  undo.Made(directory.experiment_file());
  WriteFileAtomically(directory.experiment_file(), resolved_text);
  undo.Keep();
  return directory;
}

// What ended before its first checkpoint and was refused or stopped: nothing was learnt there.
bool RunDirectory::IsVoid(const std::string& path) {
  const RunDirectory directory(path);
  std::error_code none;
  if (!fs::exists(directory.experiment_file(), none) || !fs::exists(directory.info_file(), none)) return false;
  if (fs::exists(path + "/summary.json", none)) return false;
  for (const auto& entry : fs::directory_iterator(path + "/checkpoints", none)) {
    const fs::path kind = entry.path().extension();
    if (kind == ".ckpt" || kind == ".policy") return false;
  }
  return !IsLive(ReadRunInfo(directory));
}

// Moves what is the run's into void-1, void-2, …; other files stay where they are.
void RunDirectory::SetAside(const std::string& path) {
  std::string aside;
  for (int i = 1; aside.empty() || fs::exists(aside); ++i) aside = fmt::format("{}/void-{}", path, i);
  fs::create_directory(aside);
  for (const auto& entry : std::vector<fs::directory_entry>(fs::directory_iterator(path), {})) {
    const std::string name = entry.path().filename();
    const bool ours = std::find(std::begin(kRunFiles), std::end(kRunFiles), name) != std::end(kRunFiles) ||
                      name == "log" || name == kMapFolder || name == kRoadmapFolder ||
                      name.rfind("events.out.", 0) == 0;
    if (ours) fs::rename(entry.path(), fs::path(aside) / name);
  }
}

void RunDirectory::CheckVacant(const std::string& path) {
  if (IsVoid(path)) return;
  for (const char* file : kRunFiles) {
    std::error_code unreadable;
    if (fs::exists(fs::path(path) / file, unreadable)) ThrowTaken(path, file);
    if (unreadable && unreadable != std::errc::no_such_file_or_directory) {
      ThrowError("run directory {}: {}", path, unreadable.message());
    }
  }
}

RunDirectory RunDirectory::Open(const std::string& path) {
  RunDirectory directory(fs::absolute(path).lexically_normal().string());
  std::error_code unreadable;
  if (!fs::is_directory(directory.path_, unreadable)) {
    const bool gone = !unreadable || unreadable == std::errc::no_such_file_or_directory;
    ThrowUsageError("run directory {}: {}", path, gone ? "there is no such directory" : unreadable.message());
  }
  if (!fs::exists(directory.experiment_file())) {
    ThrowUsageError("run directory {}: it holds no experiment.textproto, so it is not a run", path);
  }
  return directory;
}

bool RunDirectory::has_checkpoint() const {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(path_ + "/checkpoints", error)) {
    if (entry.path().extension() == ".ckpt") return true;
  }
  return false;
}

RunDirectory RunDirectory::Resume(const std::string& path, int64_t total_env_steps) {
  RunDirectory directory = Open(path);
  if (!directory.has_checkpoint()) ThrowUsageError("--resume {}: checkpoints/ holds none to go on from", path);
  CheckNotLive(directory, "--resume " + path);
  std::ifstream file(directory.path_ + "/summary.json");
  const nlohmann::json summary = nlohmann::json::parse(file, nullptr, false);
  if (summary.is_object() && summary.value("completed", false) &&
      summary.value("env_steps", int64_t{0}) >= total_env_steps) {
    ThrowUsageError(
        "--resume {}: the run is complete ({} env steps); a larger total_env_steps in its experiment.textproto "
        "lets it go on",
        path, total_env_steps);
  }
  return directory;
}

void RunDirectory::CheckNotLive(const RunDirectory& directory, const std::string& what) {
  if (!fs::exists(directory.info_file())) return;
  const RunInfo info = ReadRunInfo(directory);
  if (IsLive(info)) ThrowUsageError("{}: the run goes on (process {})", what, info.pid);
}

std::string HostName() {
  std::array<char, 256> name{};
  gethostname(name.data(), name.size() - 1);
  return name.data();
}

bool IsLive(const RunInfo& info) {
  // The number of a process that is gone may by now belong to another one, also on another host.
  return IsCairn(info.pid) && NetworkInode(static_cast<pid_t>(info.pid)) == info.network.inode;
}

std::string JoinCommand(const BusConfig& bus) {
  return fmt::format("cairn actor experiment.textproto --lcm-url '{}' --run-id {:x} {} --actor-id N",
                     ToLcmUrl(TransportOf(bus)), bus.run_id, bus.key ? "--key key" : "--insecure");
}

void WriteRunInfo(const RunDirectory& directory, const RunInfo& info) {
  nlohmann::ordered_json json;
  json["pid"] = info.pid;
  json["host"] = info.host;
  json["run_id"] = fmt::format("{:x}", info.run_id);
  json["group"] = info.bus.group;
  json["base_port"] = info.bus.base_port;
  json["ttl"] = info.bus.ttl;
  if (!info.bus.broker.empty()) json["broker"] = info.bus.broker;
  if (!info.bus.telemetry_broker.empty()) json["telemetry_broker"] = info.bus.telemetry_broker;
  json["lcm_url"] = ToLcmUrl(TransportOf(info.bus));
  if (TransportOf(info.bus).leaves_host()) {
    json["join"] = JoinCommand(info.bus);
    json["copy_to_other_hosts"] = nlohmann::json::array({directory.experiment_file()});
    if (fs::exists(directory.map_folder())) json["copy_to_other_hosts"].push_back(directory.map_folder());
    if (fs::exists(directory.roadmap_folder())) json["copy_to_other_hosts"].push_back(directory.roadmap_folder());
    if (info.bus.key) json["copy_to_other_hosts"].push_back(directory.key_file());
  }
  for (int plane = 0; plane < kNumPlanes; ++plane) {
    json["urls"][PlaneName(static_cast<Plane>(plane))] = PlaneUrl(info.bus, static_cast<Plane>(plane));
  }
  json["network_namespace"] = info.network.inode;
  json["private_network"] = info.network.is_private;
  json["user_namespace"] = info.network.user_namespace;
  json["actors"] = info.actors;
  json["git_revision"] = GitRevision();
  WriteFileAtomically(directory.info_file(), json.dump(2) + "\n");
}

RunInfo ReadRunInfo(const RunDirectory& directory) {
  std::ifstream file(directory.info_file());
  if (!file)
    ThrowUsageError("{}: there is no such file; was this run started by `cairn train`?", directory.info_file());
  try {
    const nlohmann::json json = nlohmann::json::parse(file);
    RunInfo info;
    info.pid = Get<int64_t>(json, "pid");
    info.host = json.value("host", "");
    info.run_id = std::stoll(Get<std::string>(json, "run_id"), nullptr, 16);
    info.bus.group = Get<std::string>(json, "group");
    info.bus.base_port = Get<int>(json, "base_port");
    info.bus.ttl = Get<int>(json, "ttl");
    info.bus.broker = json.value("broker", "");
    info.bus.telemetry_broker = json.value("telemetry_broker", "");
    info.bus.run_id = info.run_id;
    info.network = {Get<bool>(json, "private_network"), Get<bool>(json, "user_namespace"),
                    Get<uint64_t>(json, "network_namespace")};
    info.actors = Get<int>(json, "actors");
    return info;
  } catch (const std::exception& error) {
    ThrowUsageError("{}: not a run description: {}", directory.info_file(), error.what());
  }
}

}  // namespace cairn::deploy
