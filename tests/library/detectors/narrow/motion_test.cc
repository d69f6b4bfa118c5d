// `batch` in motion: what stands stays, what slides keeps its height, and what rolls rolls.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "library/layouts/initial_state.h"
#include "runtime/engine/world/engine.h"
#include "tests/support/scene.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;

constexpr double kSide = 40;

struct Start {
  objects::Solid solid;
  Vector3d position;  ///< above the floor, which is a plane
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
  Vector3d velocity = Vector3d::Zero();
};

class Motion : public testing::Test {
 protected:
  void Run(const std::vector<Start>& objects, int cycles) {
    plan::Scene scene = DefaultScene(objects.size(), kSide);
    SetWorld(scene, "precision", Word(world::EnginePrecision()));
    SetWorld(scene, "narrow_phase", Word("batch"));
    SetWorld(scene, "sleeping", false);
    SetWorld(scene, "acceleration", Vector3d(0, -9.81, 0));
    SetGroup(scene, "size", 1.0);
    layouts::InitialState state = layouts::MakeInitialState(scene);
    for (std::size_t i = 0; i < objects.size(); ++i) {
      layouts::ObjectState& object = state.objects[i];
      object.solid = objects[i].solid;
      object.pose = {objects[i].position - Vector3d(0, kSide / 2, 0), objects[i].turn};
      object.linear_velocity = objects[i].velocity;
    }
    engine_ = std::make_unique<world::Engine>(scene, state, omissions::KeepEverything(scene),
                                              detection::MakeDetectors(scene));
    for (int i = 0; i < cycles; ++i) engine_->Step();
  }
  const btRigidBody& Body(std::size_t i) const { return *engine_->objects()[i]; }
  double Height(std::size_t i) const {
    return static_cast<double>(Body(i).getWorldTransform().getOrigin().y()) + kSide / 2;
  }

  std::unique_ptr<world::Engine> engine_;
};

TEST_F(Motion, BoxesStayStacked) {
  std::vector<Start> boxes;
  for (int i = 0; i < 6; ++i)
    boxes.push_back({{objects::Shape::kCuboid, Vector3d(1, 1, 1)}, Vector3d(0, 0.5 + i, 0)});
  Run(boxes, 600);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    EXPECT_NEAR(Height(i), 0.5 + static_cast<double>(i), 0.02) << i;
    EXPECT_LT(Body(i).getLinearVelocity().length(), 0.01) << i;
  }
}

TEST_F(Motion, APlateThatSlidesDoesNotSink) {
  Run({{{objects::Shape::kCuboid, Vector3d(2, 0.1, 2)},
        Vector3d(-15, 0.05, 0),
        Eigen::Quaterniond::Identity(),
        Vector3d(8, 0, 0)}},
      60);
  EXPECT_NEAR(Height(0), 0.05, 0.005);
  EXPECT_NEAR(static_cast<double>(Body(0).getAngularVelocity().length()), 0, 0.01);
  EXPECT_GT(Body(0).getWorldTransform().getOrigin().x(), -13);
}

TEST_F(Motion, ACapsuleThatLiesRolls) {
  // It lies along z and slides at first, until friction makes it roll.
  Run({{{objects::Shape::kCapsule, Vector3d(1, 3, 1)},
        Vector3d(-15, 0.5, 0),
        Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitX())),
        Vector3d(3, 0, 0)}},
      180);
  const double speed = static_cast<double>(Body(0).getLinearVelocity().x());
  EXPECT_NEAR(Height(0), 0.5, 0.01);
  EXPECT_GT(speed, 1.5);
  EXPECT_LT(speed, 2.5);
  EXPECT_NEAR(static_cast<double>(Body(0).getAngularVelocity().z()), -speed / 0.5, 0.1);
}

}  // namespace
}  // namespace cdb::tests
