#include "common/world/import/gazebo_world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/common/world/import/map_files.h"

namespace cairn {
namespace {

using testing::HasSubstr;

std::string Model(const std::string& name, const std::string& pose, const std::string& shape,
                  const std::string& collision_pose = "") {
  return fmt::format(
      "<model name='{}'><static>1</static>{}<link name='link'><inertial><mass>1</mass></inertial>"
      "<collision name='collision'>{}<geometry>{}</geometry></collision>"
      "<visual name='visual'><geometry><mesh/></geometry></visual></link></model>",
      name, pose.empty() ? "" : "<pose frame=''>" + pose + "</pose>",
      collision_pose.empty() ? "" : "<pose>" + collision_pose + "</pose>", shape);
}

constexpr const char* kCylinder = "<cylinder><radius>0.075000</radius><length>1</length></cylinder>";
constexpr const char* kBox = "<box><size>2 1 0.5</size></box>";

std::string World(const std::string& models, const std::string& state = "") {
  return "<sdf version='1.6'><world name='default'>" +
         Model("ground_plane", "", "<plane><normal>0 0 1</normal><size>100 100</size></plane>") + models +
         "<state world_name='default'>" + state + "</state></world></sdf>";
}

GazeboObstacles Read(const std::string& text, const std::optional<Slice>& slice = std::nullopt) {
  return ReadGazeboWorld(text, "a.world", slice);
}

std::string Error(const std::string& text) {
  return ErrorOf([&] { Read(text); });
}

TEST(GazeboWorldTest, CylindersAsBarnHasThem) {
  const GazeboObstacles obstacles =
      Read(World(Model("unit_cylinder_0", "-0.075000 0.225000 0.500000 0.000000 0.000000 0.000000", kCylinder)));
  ASSERT_EQ(obstacles.cylinders.size(), 1u);
  EXPECT_TRUE(obstacles.cylinders[0].base.isApprox(Vector3d(-0.075, 0.225, 0)));
  EXPECT_EQ(obstacles.cylinders[0].radius, 0.075);
  EXPECT_EQ(obstacles.cylinders[0].height, 1);
  EXPECT_TRUE(obstacles.boxes.empty());
}

TEST(GazeboWorldTest, TheStateMovesItsModels) {
  const GazeboObstacles obstacles =
      Read(World(Model("a", "1 1 0 0 0 0", kCylinder) + Model("b", "2 2 0 0 0 0", kCylinder),
                 "<model name='b'><pose frame=''>5 6 0.5 0 -0 0</pose><link name='link'/></model>"));
  ASSERT_EQ(obstacles.cylinders.size(), 2u);
  EXPECT_EQ(obstacles.cylinders[0].base.head<2>(), Eigen::Vector2d(1, 1));
  EXPECT_EQ(obstacles.cylinders[1].base.head<2>(), Eigen::Vector2d(5, 6));
}

// The model turned by a right angle carries its collision, one metre along its own x, to one metre along y.
TEST(GazeboWorldTest, PosesOfModelAndCollisionAreComposed) {
  const GazeboObstacles obstacles = Read(World(Model("a", "3 4 0 0 0 1.5707963267948966", kCylinder, "1 0 0.5 0 0 0") +
                                               Model("b", "3 4 1 0 0 -1.5707963267948966", kBox)));
  EXPECT_TRUE(obstacles.cylinders[0].base.isApprox(Vector3d(3, 5, 0), 1e-9));
  ASSERT_EQ(obstacles.boxes.size(), 1u);
  EXPECT_TRUE(obstacles.boxes[0].min.isApprox(Vector3d(2.5, 3, 0.75)));  // 2 × 1 m, turned
  EXPECT_TRUE(obstacles.boxes[0].max.isApprox(Vector3d(3.5, 5, 1.25)));
}

TEST(GazeboWorldTest, ASliceLeavesOutWhatIsAboveTheRobot) {
  const std::string text = World(Model("lamp", "0 0 3 0 0 0", kCylinder) + Model("post", "1 1 0.5 0 0 0", kCylinder) +
                                 Model("shelf", "2 2 2 0 0 0", kBox));
  EXPECT_EQ(Read(text).cylinders.size(), 2u);
  const GazeboObstacles low = Read(text, Slice{0.05, 0.3});
  ASSERT_EQ(low.cylinders.size(), 1u);
  EXPECT_EQ(low.cylinders[0].base.x(), 1);
  EXPECT_TRUE(low.boxes.empty());
}

TEST(GazeboWorldErrorTest, NamesModelAndRule) {
  EXPECT_THAT(Error(World(Model("m", "0 0 0 0 0 0", "<mesh><uri>a.dae</uri></mesh>"))),
              HasSubstr("a.world: model m: a collision shape <mesh>"));
  EXPECT_THAT(Error(World(Model("m", "0 0 0 0 0 0.3", kBox))), HasSubstr("a box turned by 0.3 rad"));
  EXPECT_THAT(Error(World(Model("m", "0 0 0 0.2 0 0", kCylinder))), HasSubstr("model m: it is tilted"));
  EXPECT_THAT(Error(World(Model("m", "0 0 0", kCylinder))),
              HasSubstr("model m: <pose> \"0 0 0\"; it must be 6 finite numbers"));
  EXPECT_THAT(Error(World(Model("m", "0 0 nan 0 0 0", kCylinder))), HasSubstr("it must be 6 finite numbers"));
  EXPECT_THAT(Error(World(Model("m", "0 1e9 0 0 0 0", kCylinder))), HasSubstr("within ±10000 m"));
  EXPECT_THAT(Error(World(Model("m", "0 0 0 0 0 0", "<cylinder><radius>-1</radius><length>1</length></cylinder>"))),
              HasSubstr("model m: radius = -1 m; it must be above 0"));
  EXPECT_THAT(Error(World(Model("m", "0 0 0 0 0 0", "<cylinder><length>1</length></cylinder>"))),
              HasSubstr("1 finite number"));
  EXPECT_THAT(Error(World("<model name='m'><include/></model>")), HasSubstr("models within models"));
  EXPECT_THAT(Error(World("<include><uri>model://x</uri></include>")), HasSubstr("<include> of other files"));
  EXPECT_THAT(Error("<sdf/>"), HasSubstr("there is no <sdf><world>"));
  EXPECT_THAT(Error("<sdf>\n<world>\n</sdf>"), HasSubstr("a.world:3: not XML"));
}

TEST(GazeboWorldErrorTest, TornFilesAreRefusedAtEveryLength) {
  const std::string text = World(Model("a", "1 1 0 0 0 0", kCylinder));
  for (size_t length = 0; length < text.size(); ++length) EXPECT_NE(Error(text.substr(0, length)), "") << length;
}

}  // namespace
}  // namespace cairn
