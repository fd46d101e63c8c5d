#include "tests/benchmarks/bullet_scene.h"

#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "actors/vehicles/quadrotor/quadrotor.h"
#include "actors/vehicles/quadruped/quadruped.h"
#include "actors/vehicles/wheeled_car/wheeled_car.h"
#include "common/core/check.h"

namespace cairn::actors {
namespace {

// A body meets what its mask names, and nothing of its own robot, as under ODE.
constexpr int kRobot = 1, kWall = 2, kFloor = 4;
constexpr double kWallHeight = 0.2;  // of a plane world's walls [m]

btScalar Scalar(double value) { return static_cast<btScalar>(value); }
btVector3 Vector(double x, double y, double z) { return {Scalar(x), Scalar(y), Scalar(z)}; }

btTransform PoseAt(double x, double y, double z, const btQuaternion& rotation) {
  return btTransform(rotation, Vector(x, y, z));
}

btQuaternion About(const btVector3& axis, double angle) { return btQuaternion(axis, Scalar(angle)); }

}  // namespace

// Owns all that Bullet keeps pointers to; the world goes first.
struct BulletScene::State {
  explicit State(const Scene& s);
  ~State();

  btRigidBody* Add(btCollisionShape* shape, double mass, const btVector3& inertia, const btTransform& at, int group,
                   int mask, double friction = 1);
  void AddWalls();
  void AddFloor();
  void AddJoint(btTypedConstraint* joint);
  bool TouchesWall();

  const Scene& scene;
  double time_step;
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  std::unique_ptr<btDiscreteDynamicsWorld> world;
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btMotionState>> motion_states;
  std::vector<std::unique_ptr<btRigidBody>> bodies;
  std::vector<std::unique_ptr<btTypedConstraint>> joints;
  std::vector<btRigidBody*> robot_bodies;
  std::unique_ptr<Robot> robot;
};

class BulletScene::Robot {
 public:
  explicit Robot(State& state) : state_(state) {}
  virtual ~Robot() = default;
  virtual void Reset(const Pose& pose) = 0;
  virtual void Drive() = 0;  // before each physics step
  virtual const btRigidBody& base() const = 0;
  void Command(const VehicleCommand& command) { command_ = command; }

  Motion motion() const {
    const btTransform& at = base().getWorldTransform();
    const btVector3 v = base().getLinearVelocity();
    const double yaw = std::atan2(at.getBasis()[1][0], at.getBasis()[0][0]);
    const double c = std::cos(yaw), s = std::sin(yaw);
    const bool space = state_.scene.world().dimension == 3;
    Motion m{at.getOrigin().x(),    at.getOrigin().y(),    0, yaw,
             c * v.x() + s * v.y(), c * v.y() - s * v.x(), 0, base().getAngularVelocity().z()};
    if (space) m.z = at.getOrigin().z(), m.vz = v.z();
    return m;
  }

 protected:
  template <typename Shape, typename... Arguments>
  Shape* MakeShape(Arguments&&... arguments) {
    auto shape = std::make_unique<Shape>(std::forward<Arguments>(arguments)...);
    shape->setMargin(std::min<btScalar>(shape->getMargin(), Scalar(1e-3)));
    Shape* raw = shape.get();
    state_.shapes.push_back(std::move(shape));
    return raw;
  }

  static btVector3 BoxInertia(double mass, double x, double y, double z) {
    return Vector(mass * (y * y + z * z) / 12, mass * (x * x + z * z) / 12, mass * (x * x + y * y) / 12);
  }

  btRigidBody* Add(btCollisionShape* shape, double mass, const btVector3& inertia, const btTransform& at, int mask,
                   double friction = 1) {
    btRigidBody* body = state_.Add(shape, mass, inertia, at, kRobot, mask, friction);
    body->setActivationState(DISABLE_DEACTIVATION);
    state_.robot_bodies.push_back(body);
    return body;
  }

  static void Place(btRigidBody* body, const btTransform& at) {
    body->setWorldTransform(at);
    body->setInterpolationWorldTransform(at);
    body->getMotionState()->setWorldTransform(at);
    body->setLinearVelocity(Vector(0, 0, 0));
    body->setAngularVelocity(Vector(0, 0, 0));
    body->clearForces();
  }

  State& state_;
  VehicleCommand command_{};
};

// A sphere pulled to its velocity by a force at its centre: cheaper than the rotors and attitude control under ODE.
class BulletScene::Quadcopter final : public Robot {
 public:
  explicit Quadcopter(State& state) : Robot(state), p_(QuadrotorParams::ScaledTo(state.scene.experiment().vehicle)) {
    body_ = Add(MakeShape<btSphereShape>(Scalar(p_.radius)), p_.mass,
                Vector(p_.inertia[0], p_.inertia[1], p_.inertia[2]), btTransform::getIdentity(), kWall);
  }
  void Reset(const Pose& pose) override { Place(body_, PoseAt(pose.x, pose.y, pose.z, btQuaternion(0, 0, 0, 1))); }
  void Drive() override {
    const btVector3 wanted = Vector(command_[0], command_[1], command_[2]);
    body_->applyCentralForce(Scalar(p_.mass) * (Scalar(p_.velocity_gain) * (wanted - body_->getLinearVelocity()) +
                                                Vector(0, 0, p_.world.gravity)));
  }
  const btRigidBody& base() const override { return *body_; }

 private:
  QuadrotorParams p_;
  btRigidBody* body_;
};

class BulletScene::Car final : public Robot {
 public:
  explicit Car(State& state) : Robot(state), p_(WheeledCarParams::ScaledTo(state.scene.experiment().vehicle)) {
    auto* chassis = MakeShape<btCompoundShape>();
    chassis->addChildShape(btTransform::getIdentity(),
                           MakeShape<btBoxShape>(0.5 * Vector(p_.length, p_.width, p_.height)));
    const double z = p_.caster_radius + p_.caster_clearance - p_.chassis_height;
    auto* caster = MakeShape<btSphereShape>(Scalar(p_.caster_radius));
    for (const double x : {p_.caster_x, -p_.caster_x}) {
      chassis->addChildShape(PoseAt(x, 0, z, btQuaternion(0, 0, 0, 1)), caster);
    }
    chassis_ = Add(chassis, p_.chassis_mass, BoxInertia(p_.chassis_mass, p_.length, p_.width, p_.height),
                   PoseAt(0, 0, p_.chassis_height, btQuaternion(0, 0, 0, 1)), kWall | kFloor, 0);
    auto* wheel = MakeShape<btSphereShape>(Scalar(p_.wheel_radius));
    const double inertia = 0.4 * p_.wheel_mass * p_.wheel_radius * p_.wheel_radius;
    for (int i = 0; i < 2; ++i) {
      const double y = (i == 0 ? 0.5 : -0.5) * p_.track;
      wheels_[i] = Add(wheel, p_.wheel_mass, Vector(inertia, inertia, inertia),
                       PoseAt(0, y, p_.wheel_radius, btQuaternion(0, 0, 0, 1)), kFloor, p_.friction);
      const btVector3 axle = Vector(0, 1, 0);
      hinges_[i] = new btHingeConstraint(*chassis_, *wheels_[i], Vector(0, y, p_.wheel_radius - p_.chassis_height),
                                         Vector(0, 0, 0), axle, axle);
      state.AddJoint(hinges_[i]);
    }
  }
  void Reset(const Pose& pose) override {
    const btQuaternion heading = About(Vector(0, 0, 1), pose.yaw);
    Place(chassis_, PoseAt(pose.x, pose.y, p_.chassis_height, heading));
    for (int i = 0; i < 2; ++i) {
      const double side = (i == 0 ? 0.5 : -0.5) * p_.track;
      Place(wheels_[i],
            PoseAt(pose.x - side * std::sin(pose.yaw), pose.y + side * std::cos(pose.yaw), p_.wheel_radius, heading));
    }
  }
  void Drive() override {
    for (int i = 0; i < 2; ++i) {
      const double side = (i == 0 ? 0.5 : -0.5) * p_.track;
      const double limit = p_.wheel_speed_limit;
      const double speed = std::clamp((command_[0] - side * command_[1]) / p_.wheel_radius, -limit, limit);
      // Bullet's hinge counts the chassis's turn against the wheel.
      hinges_[i]->enableAngularMotor(true, Scalar(-speed), Scalar(p_.motor_torque * state_.time_step));
    }
  }
  const btRigidBody& base() const override { return *chassis_; }

 private:
  WheeledCarParams p_;
  btRigidBody* chassis_;
  std::array<btRigidBody*, 2> wheels_;
  std::array<btHingeConstraint*, 2> hinges_;
};

// The same trot drives it, by the same inverse kinematics.
class BulletScene::Walker final : public Robot {
 public:
  explicit Walker(State& state)
      : Robot(state), p_(QuadrupedParams::ScaledTo(state.scene.experiment().vehicle)), trot_(p_.trot) {
    trunk_ = Add(MakeShape<btBoxShape>(0.5 * Vector(p_.length, p_.width, p_.height)), p_.trunk_mass,
                 BoxInertia(p_.trunk_mass, p_.length, p_.width, p_.height), btTransform::getIdentity(), kWall);
    for (int leg = 0; leg < 4; ++leg) AddLeg(leg);
  }

  void Reset(const Pose& pose) override {
    trot_.Reset();
    velocity_ = {};
    const LegAngles stance = InverseKinematics(p_.leg, {0, 0, -p_.trot.leg_height});
    wanted_.fill(stance);
    const btTransform trunk = PoseAt(pose.x, pose.y, p_.stance_height, About(Vector(0, 0, 1), pose.yaw));
    Place(trunk_, trunk);
    for (int leg = 0; leg < 4; ++leg) {
      const Leg& l = legs_[leg];
      const btTransform hip = PoseAt(p_.trot.hip_x[leg], p_.trot.hip_y[leg], 0, About(Vector(0, 1, 0), stance.hip));
      const btTransform knee = PoseAt(0, 0, -p_.leg.thigh, About(Vector(0, 1, 0), stance.knee));
      Place(l.thigh, trunk * hip * Down(p_.leg.thigh));
      Place(l.shank, trunk * hip * knee * Down(p_.leg.shank));
    }
  }

  void Drive() override {
    Approach();
    const Motion m = motion();
    const auto feet = trot_.Advance(state_.time_step, velocity_, {m.vx, m.vy, m.yaw_rate});
    const auto speed = [this](double next, double wanted, double now) {
      return Scalar(std::clamp((next - wanted) / state_.time_step + p_.joint_gain * (wanted - now), -p_.joint_speed,
                               p_.joint_speed));
    };
    for (int leg = 0; leg < 4; ++leg) {
      const LegAngles next = InverseKinematics(p_.leg, feet[leg]), now = Angles(leg);
      LegAngles& wanted = wanted_[leg];
      const Leg& l = legs_[leg];
      // Bullet's joints count the first body's turn against the second.
      l.hip->getRotationalLimitMotor(2)->m_targetVelocity = -speed(next.abduction, wanted.abduction, now.abduction);
      l.hip->getRotationalLimitMotor(1)->m_targetVelocity = -speed(next.hip, wanted.hip, now.hip);
      l.knee->enableAngularMotor(true, -speed(next.knee, wanted.knee, now.knee),
                                 Scalar(p_.joint_torque * state_.time_step));
      wanted = next;
    }
  }

  const btRigidBody& base() const override { return *trunk_; }

 private:
  struct Leg {
    btRigidBody *thigh, *shank;
    btUniversalConstraint* hip;
    btHingeConstraint* knee;
  };

  static btTransform Down(double length) { return PoseAt(0, 0, -0.5 * length, btQuaternion(0, 0, 0, 1)); }

  void AddLeg(int leg) {
    const double x = p_.trot.hip_x[leg], y = p_.trot.hip_y[leg], w = p_.link_width;
    const double thigh = p_.leg.thigh, shank = p_.leg.shank;
    Leg& l = legs_[leg];
    const btQuaternion upright(0, 0, 0, 1);
    l.thigh = Add(MakeShape<btEmptyShape>(), p_.thigh_mass, BoxInertia(p_.thigh_mass, w, w, thigh),
                  PoseAt(x, y, -0.5 * thigh, upright), 0);
    auto* foot = MakeShape<btCompoundShape>();
    foot->addChildShape(Down(shank), MakeShape<btSphereShape>(Scalar(p_.foot_radius)));
    l.shank = Add(foot, p_.shank_mass, BoxInertia(p_.shank_mass, w, w, shank),
                  PoseAt(x, y, -thigh - 0.5 * shank, upright), kFloor, p_.surface.friction);
    // ODE's ERP and CFM are a spring and a damper: erp = h k / (h k + d), cfm = 1 / (h k + d).
    const double erp = p_.surface.soft_erp, cfm = p_.surface.soft_cfm;
    l.shank->setContactStiffnessAndDamping(Scalar(erp / (state_.time_step * cfm)), Scalar((1 - erp) / cfm));
    l.hip = new btUniversalConstraint(*trunk_, *l.thigh, Vector(x, y, 0), Vector(1, 0, 0), Vector(0, 1, 0));
    for (const int axis : {1, 2}) {
      btRotationalLimitMotor* motor = l.hip->getRotationalLimitMotor(axis);
      motor->m_enableMotor = true;
      motor->m_maxMotorForce = Scalar(p_.joint_torque);
    }
    state_.AddJoint(l.hip);
    const btVector3 axis = Vector(0, 1, 0);
    l.knee =
        new btHingeConstraint(*l.thigh, *l.shank, Vector(0, 0, -0.5 * thigh), Vector(0, 0, 0.5 * shank), axis, axis);
    state_.AddJoint(l.knee);
  }

  void Approach() {
    const double dv = p_.acceleration * state_.time_step, dw = p_.yaw_acceleration * state_.time_step;
    velocity_.x += std::clamp(command_[0] - velocity_.x, -dv, dv);
    velocity_.yaw_rate += std::clamp(command_[1] - velocity_.yaw_rate, -dw, dw);
  }

  LegAngles Angles(int leg) const {
    const btMatrix3x3& trunk = trunk_->getWorldTransform().getBasis();
    const btMatrix3x3& thigh = legs_[leg].thigh->getWorldTransform().getBasis();
    const btMatrix3x3& shank = legs_[leg].shank->getWorldTransform().getBasis();
    const auto dot = [](const btMatrix3x3& a, int i, const btMatrix3x3& b, int j) {
      return static_cast<double>(a.getColumn(i).dot(b.getColumn(j)));
    };
    return {std::atan2(dot(trunk, 2, thigh, 1), dot(trunk, 1, thigh, 1)),
            std::atan2(dot(trunk, 0, thigh, 2), dot(trunk, 0, thigh, 0)),
            std::atan2(dot(thigh, 0, shank, 2), dot(thigh, 0, shank, 0))};
  }

  QuadrupedParams p_;
  Trot trot_;
  Trot::Velocity velocity_;
  btRigidBody* trunk_;
  std::array<Leg, 4> legs_;
  std::array<LegAngles, 4> wanted_{};
};

BulletScene::State::State(const Scene& s) : scene(s), time_step(1 / s.experiment().environment.physics_rate_hz) {
  world = std::make_unique<btDiscreteDynamicsWorld>(&dispatcher, &broadphase, &solver, &configuration);
  world->setGravity(Vector(0, 0, -9.81));
  // Kind to Bullet: by default it would look at the bounds of every wall in every step.
  world->setForceUpdateAllAabbs(false);
  AddWalls();
  if (scene.world().dimension == 2) AddFloor();
  switch (scene.experiment().vehicle.kind) {
    case VehicleConfig::Kind::kWheeledCar:
      robot = std::make_unique<Car>(*this);
      return;
    case VehicleConfig::Kind::kQuadrotor:
      robot = std::make_unique<Quadcopter>(*this);
      return;
    case VehicleConfig::Kind::kQuadruped:
      robot = std::make_unique<Walker>(*this);
      return;
    default:
      ThrowUsageError("no such vehicle in the Bullet scene");
  }
}

BulletScene::State::~State() {
  for (const auto& joint : joints) world->removeConstraint(joint.get());
  for (const auto& body : bodies) world->removeRigidBody(body.get());
  robot.reset();
  world.reset();
}

btRigidBody* BulletScene::State::Add(btCollisionShape* shape, double mass, const btVector3& inertia,
                                     const btTransform& at, int group, int mask, double friction) {
  motion_states.push_back(std::make_unique<btDefaultMotionState>(at));
  btRigidBody::btRigidBodyConstructionInfo info(Scalar(mass), motion_states.back().get(), shape, inertia);
  info.m_friction = Scalar(friction);
  bodies.push_back(std::make_unique<btRigidBody>(info));
  world->addRigidBody(bodies.back().get(), group, mask);
  return bodies.back().get();
}

void BulletScene::State::AddWalls() {
  const bool space = scene.world().dimension == 3;
  for (const Box& box : scene.world().boxes) {
    const Vector3d half = 0.5 * box.size(), center = box.center();
    auto shape = std::make_unique<btBoxShape>(Vector(half.x(), half.y(), space ? half.z() : 0.5 * kWallHeight));
    shape->setMargin(Scalar(1e-3));
    const btTransform at =
        PoseAt(center.x(), center.y(), space ? center.z() : 0.5 * kWallHeight, btQuaternion(0, 0, 0, 1));
    Add(shape.get(), 0, Vector(0, 0, 0), at, kWall, kRobot)->setUserIndex(kWall);
    shapes.push_back(std::move(shape));
  }
}

void BulletScene::State::AddFloor() {
  auto shape = std::make_unique<btStaticPlaneShape>(Vector(0, 0, 1), Scalar(0));
  Add(shape.get(), 0, Vector(0, 0, 0), btTransform::getIdentity(), kFloor, kRobot);
  shapes.push_back(std::move(shape));
}

void BulletScene::State::AddJoint(btTypedConstraint* joint) {
  joints.emplace_back(joint);
  world->addConstraint(joint, true);
}

bool BulletScene::State::TouchesWall() {
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold* manifold = dispatcher.getManifoldByIndexInternal(i);
    if (manifold->getBody0()->getUserIndex() != kWall && manifold->getBody1()->getUserIndex() != kWall) continue;
    for (int k = 0; k < manifold->getNumContacts(); ++k) {
      if (manifold->getContactPoint(k).getDistance() <= 0) return true;
    }
  }
  return false;
}

BulletScene::BulletScene(const Scene& scene, int iterations) : state_(std::make_unique<State>(scene)) {
  state_->world->getSolverInfo().m_numIterations = iterations;
}

BulletScene::~BulletScene() = default;

void BulletScene::Reset(const Pose& pose) {
  State& s = *state_;
  s.robot->Reset(pose);
  for (btRigidBody* body : s.robot_bodies) {
    s.broadphase.getOverlappingPairCache()->cleanProxyFromPairs(body->getBroadphaseHandle(), &s.dispatcher);
    s.world->updateSingleAabb(body);
  }
}

void BulletScene::Command(const VehicleCommand& command) { state_->robot->Command(command); }

bool BulletScene::Step() {
  state_->robot->Drive();
  state_->world->stepSimulation(Scalar(state_->time_step), 0);
  return state_->TouchesWall();
}

Motion BulletScene::motion() const { return state_->robot->motion(); }

}  // namespace cairn::actors
