#pragma once

namespace cairn::actors {

/// Angles of a leg [rad]: the leg turns by `abduction` about the trunk's x axis, then by `hip` about its own y axis,
/// the shank by `knee` about the same axis. All zero: straight down. A negative knee angle points the knee backwards.
struct LegAngles {
  double abduction = 0, hip = 0, knee = 0;
};

/// Centre of a foot relative to its hip, in the trunk's frame [m].
struct FootPosition {
  double x = 0, y = 0, z = 0;
};

/// Lengths of a leg's links, hip to knee and knee to the foot's centre [m].
struct LegLengths {
  double thigh = 0, shank = 0;
};

FootPosition ForwardKinematics(const LegLengths& lengths, const LegAngles& angles);

/// The angles, knee backwards, that put the foot there; one that is out of reach is drawn in along the line to the hip.
LegAngles InverseKinematics(const LegLengths& lengths, const FootPosition& foot);

}  // namespace cairn::actors
