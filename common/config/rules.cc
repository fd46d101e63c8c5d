#include "common/config/rules.h"

#include <arpa/inet.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <tuple>

#include "common/config/lcm_url.h"
#include "common/core/check.h"

namespace cairn::config {
namespace {

// One named value of the draft, for comparisons.
template <typename T>
struct Named {
  std::string path;
  T value;
};

template <typename T>
void CheckAtMost(const Draft& draft, const Named<T>& low, const Named<T>& high) {
  if (low.value <= high.value) return;
  ThrowUsageError("{} must not exceed {}", draft.Show(low.path, low.value), draft.Show(high.path, high.value));
}

template <typename T>
void CheckBelow(const Draft& draft, const Named<T>& low, const Named<T>& high) {
  if (low.value < high.value) return;
  ThrowUsageError("{} must be below {}", draft.Show(low.path, low.value), draft.Show(high.path, high.value));
}

// The name becomes part of directory names.
void CheckName(const Draft& draft) {
  const std::string& name = draft.message.name();
  const bool clean = std::all_of(name.begin(), name.end(),
                                 [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-' || c == '.'; });
  if (clean && !name.empty() && name.size() <= 64 && name[0] != '.') return;
  ThrowUsageError("{}: name = \"{}\"; it must be 1 to 64 letters, digits, '_', '-' or '.', not beginning with '.'",
                  draft.Origin("name"), name);
}

void CheckWorld(const Draft& draft) {
  const proto::World& world = draft.message.world();
  const bool boxes = world.kind() == proto::World::BOXES, map = world.kind() == proto::World::MAP;
  const auto check = [&](const char* path, bool present, bool needed, bool of_maps) {
    if (needed && !present)
      ThrowUsageError("{} is missing: world.kind = BOXES ({}) needs it", path, draft.Origin("world.kind"));
    if (!present || boxes || (map && of_maps)) return;
    ThrowUsageError("{}: {} is read only with world.kind = BOXES{}", draft.Origin(path), path,
                    of_maps ? " or MAP" : "");
  };
  check("world.bounds", world.has_bounds(), boxes, true);
  check("world.start", world.has_start(), boxes && !world.has_start_point(), true);
  check("world.goal", world.has_goal(), boxes && !world.has_goal_point(), true);
  check("world.obstacles[0]", !world.obstacles().empty(), false, false);
  check("world.cylinders[0]", !world.cylinders().empty(), false, false);
  const auto check_one = [&](const char* region, bool has_region, const char* point, bool has_point) {
    if (!has_region || !has_point) return;
    ThrowUsageError("{}: {} does not go with {} ({})", draft.Origin(point), point, region, draft.Origin(region));
  };
  check_one("world.start", world.has_start(), "world.start_point", world.has_start_point());
  check_one("world.goal", world.has_goal(), "world.goal_point", world.has_goal_point());
  for (int i = 0; i < world.cylinders_size(); ++i) {
    const std::string path = fmt::format("world.cylinders[{}]", i);
    if (!world.cylinders(i).has_radius()) ThrowUsageError("{}: {}.radius is missing", draft.Origin(path), path);
  }
}

// A path has costs beside itself only, and a file's roadmap is of one world.
void CheckPlannerOfAnyGoal(const Draft& draft) {
  const proto::Planner& planner = draft.message.planner();
  const proto::World& world = draft.message.world();
  const bool path = planner.kind() == proto::Planner::RRT || planner.kind() == proto::Planner::RRT_STAR;
  if (planner.roadmap().empty() && path) {
    ThrowUsageError("{}: does not go with goals = ANY ({}): a path has costs towards its own goal only",
                    draft.Show("planner.kind", proto::Planner::Kind_Name(planner.kind())), draft.Origin("goals"));
  }
  const int worlds = world.training_worlds() + world.unseen_worlds();
  if (!planner.roadmap().empty() && worlds > 1) {
    ThrowUsageError(
        "{}: is of one world, and world.training_worlds = {} and world.unseen_worlds = {} make {}; leave it out, and "
        "each is planned for",
        draft.Show("planner.roadmap", planner.roadmap()), world.training_worlds(), world.unseen_worlds(), worlds);
  }
}

// What is said of many worlds and goals must mean something, and a policy that is told where it is cannot use it
// elsewhere.
void CheckGoals(const Draft& draft) {
  const proto::World& world = draft.message.world();
  const bool any = draft.message.goals() == proto::Experiment::ANY;
  const bool seeded = world.kind() == proto::World::CAR_MAZE || world.kind() == proto::World::CUBE_MAZE;
  const auto check_count = [&](const char* path, int count, int one) {
    if (count == one || (any && seeded)) return;
    if (!any) ThrowUsageError("{} is read only with goals = ANY", draft.Show(path, count));
    ThrowUsageError("{}: only CAR_MAZE and CUBE_MAZE make a world of each seed", draft.Show(path, count));
  };
  check_count("world.training_worlds", world.training_worlds(), 1);
  check_count("world.unseen_worlds", world.unseen_worlds(), 0);
  if (any && draft.message.observation().position()) {
    ThrowUsageError("{}: does not go with goals = ANY, which are told by the roadmap alone",
                    draft.Show("observation.position", "true"));
  }
  if (any) CheckPlannerOfAnyGoal(draft);
}

// A vehicle without lag stands still at once in simulation: no factor makes a way of that.
void CheckSafety(const Draft& draft) {
  const proto::Safety& safety = draft.message.safety();
  const proto::Vehicle& vehicle = draft.message.vehicle();
  const bool in_plane = vehicle.kind() == proto::Vehicle::PLANE_CAR || vehicle.kind() == proto::Vehicle::HOLONOMIC ||
                        vehicle.kind() == proto::Vehicle::ACKERMANN;
  const bool at_once = in_plane && vehicle.lag() == 0 && vehicle.max_acceleration() == 0;
  if (safety.filter() == proto::Safety::OFF || safety.stopping_distance() == 0 || !at_once) return;
  ThrowUsageError("{}: the simulated vehicle stands still at once; give it {} (a way of speed times lag) above 0",
                  draft.Show("safety.stopping_distance", safety.stopping_distance()), draft.Show("vehicle.lag", 0));
}

void CheckVehicle(const Draft& draft) {
  const proto::Vehicle& vehicle = draft.message.vehicle();
  CheckBelow<double>(draft, {"vehicle.min_speed", vehicle.min_speed()}, {"vehicle.max_speed", vehicle.max_speed()});
  const bool flies = vehicle.kind() == proto::Vehicle::QUADROTOR;
  const int beams = vehicle.scan().beams();
  if (flies && beams != 6 && beams != 14 && beams != 26) {
    ThrowUsageError("{} must be 6 (along the axes), 14 (and the cube's diagonals) or 26 (and its faces') in space",
                    draft.Show("vehicle.scan.beams", beams));
  }
  if (std::abs(vehicle.scan().mount_x()) > vehicle.length() / 2) {
    ThrowUsageError("{} must lie on the vehicle: at most half of {}",
                    draft.Show("vehicle.scan.mount_x", vehicle.scan().mount_x()),
                    draft.Show("vehicle.length", vehicle.length()));
  }
}

// A coarser spacing could never cover free space with balls of r_ball = eta / 2.
void CheckSpacing(const Draft& draft) {
  const proto::Planner& planner = draft.message.planner();
  if (planner.min_spacing() <= 0.5 * planner.eta()) return;
  ThrowUsageError("{} must not exceed r_ball = eta / 2, {}", draft.Show("planner.min_spacing", planner.min_spacing()),
                  draft.Show("planner.eta", planner.eta()));
}

void CheckPlanner(const Draft& draft) {
  CheckSpacing(draft);
  const int neighbors = draft.message.planner().grid_neighbors();
  const bool flies = draft.message.vehicle().kind() == proto::Vehicle::QUADROTOR;
  if (neighbors == (flies ? 6 : 4) || neighbors == (flies ? 26 : 8)) return;
  ThrowUsageError("{} must be {}", draft.Show("planner.grid_neighbors", neighbors),
                  flies ? "6 (along the axes) or 26 (and diagonals) for a vehicle that flies"
                        : "4 (along the axes) or 8 (and diagonals) for a vehicle in the plane");
}

// Physics has one fixed step, so that its accuracy does not depend on the control period.
void CheckControlPeriod(const Draft& draft) {
  const proto::Environment& environment = draft.message.environment();
  const double steps = environment.control_period() * environment.physics_rate_hz();
  const double nearest = std::max(1.0, std::round(steps));
  if (std::abs(steps - nearest) <= 1e-9 * nearest) return;
  ThrowUsageError("{} must be a whole number of physics steps, {}; the nearest is {}",
                  draft.Show("environment.control_period", environment.control_period()),
                  draft.Show("environment.physics_rate_hz", environment.physics_rate_hz()),
                  nearest / environment.physics_rate_hz());
}

void CheckObservation(const Draft& draft) {
  const proto::Observation& observation = draft.message.observation();
  CheckBelow<double>(draft, {"observation.look_ahead_near", observation.look_ahead_near()},
                     {"observation.look_ahead_far", observation.look_ahead_far()});
  if (observation.position() || observation.heading() || observation.velocity() || observation.d_min() ||
      observation.look_ahead() || observation.rays()) {
    return;
  }
  ThrowUsageError("{}: observation: every part is switched off; at least one must be true",
                  draft.Origin("observation"));
}

void CheckLearner(const Draft& draft) {
  const proto::Learner& learner = draft.message.learner();
  const Named<int> buffer{"learner.buffer_size", learner.buffer_size()};
  CheckAtMost<int>(draft, {"learner.batch_size", learner.batch_size()}, buffer);
  CheckAtMost<int>(draft, {"learner.learning_starts", learner.learning_starts()}, buffer);
  CheckAtMost<int>(draft, {"learner.n_steps", learner.n_steps()}, buffer);
}

// As it is known where it stands, a fault is said with that.
void CheckBrokers(const Draft& draft) {
  const proto::Transport& transport = draft.message.transport();
  for (const auto& [path, url, is_set] :
       {std::tuple("transport.url", &transport.url(), transport.has_url()),
        std::tuple("transport.telemetry_url", &transport.telemetry_url(), transport.has_telemetry_url())}) {
    if (is_set) ParseBrokerUrl(fmt::format("{}: {} =", draft.Origin(path), path), *url);
  }
  if (transport.has_telemetry_url() && !transport.has_url()) {
    ThrowUsageError("{}: transport.telemetry_url = \"{}\" goes with transport.url only, which is left out",
                    draft.Origin("transport.telemetry_url"), transport.telemetry_url());
  }
}

void CheckTransport(const Draft& draft) {
  CheckBrokers(draft);
  const std::string& group = draft.message.transport().group();
  in_addr address{};
  const bool valid = inet_pton(AF_INET, group.c_str(), &address) == 1;
  if (valid && (ntohl(address.s_addr) >> 28) == 0xE) return;
  ThrowUsageError("{}: transport.group = \"{}\"; it must be an IPv4 multicast address, 224.0.0.0 to 239.255.255.255",
                  draft.Origin("transport.group"), group);
}

}  // namespace

void CheckRules(const Draft& draft) {
  CheckName(draft);
  CheckWorld(draft);
  CheckGoals(draft);
  CheckVehicle(draft);
  CheckSafety(draft);
  CheckPlanner(draft);
  CheckControlPeriod(draft);
  CheckObservation(draft);
  CheckLearner(draft);
  CheckTransport(draft);
}

}  // namespace cairn::config
