#pragma once

#include <memory>

#include "actors/motion.h"
#include "actors/scene.h"

namespace cairn::actors {

/// The vehicle of a scene and its walls in Bullet: the same bodies, joints, motors and time step as under ODE, walls as
/// static boxes, the floor as a plane; a btDiscreteDynamicsWorld with its defaults but for the solver's iterations
/// (Bullet's default is 10, PyBullet's 50). For comparing speed.
class BulletScene {
 public:
  BulletScene(const Scene& scene, int iterations);
  ~BulletScene();

  void Reset(const Pose& pose);
  void Command(const VehicleCommand& command);
  /// One physics step; true when the vehicle touches a wall then.
  bool Step();
  Motion motion() const;

 private:
  class Robot;
  class Car;
  class Quadcopter;
  class Walker;
  struct State;

  std::unique_ptr<State> state_;
};

}  // namespace cairn::actors
