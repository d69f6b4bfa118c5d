// A worker that runs scenes under ODE in place of Bullet: what another engine needs to be measured
// by cdb, in one file. README.md beside it explains the contract.
//
// It knows balls and cuboids in a walled cube. Everything else that a scene may ask for is refused
// by name.
#include <ode/ode.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/analysis/reference.h"
#include "compiler/schema/schema.h"
#include "compiler/yaml/plan_yaml.h"
#include "library/layouts/initial_state.h"
#include "runtime/protocol/file_descriptor_io.h"
#include "runtime/protocol/fork_server.h"
#include "runtime/protocol/recording.h"

namespace {

using namespace cdb;
using Eigen::Vector3d;

double Now() {
  return static_cast<double>(std::chrono::steady_clock::now().time_since_epoch().count());
}

/// Settings that it follows, or that others follow for it: the library places the objects, and the
/// runner keeps time and memory. Any other setting must have its default.
constexpr std::string_view kFollowed =
    "cycles quantity type aspect location overlap size mass acceleration linear_velocity "
    "angular_velocity seed world.side world.walls world.wall_friction world.wall_restitution "
    "timestep precision detector "
    "solver.iterations solver.erp friction restitution orientation sleeping repeats warmup "
    "timeout memory record expect accuracy.metrics accuracy.interval accuracy.closed_form "
    "accuracy.reference.timestep accuracy.reference.precision accuracy.reference.detector "
    "accuracy.reference.iterations accuracy.reference.contact";

[[noreturn]] void Refuse(const std::string& what) {
  throw std::runtime_error("the ODE worker cannot do '" + what + "'");
}

void RequireDefault(const schema::Parameter& parameter, const plan::Settings& settings) {
  if (schema::ListsWord(kFollowed, parameter.name) || !settings.Has(parameter)) return;
  const std::string text = schema::ToText(settings.ValueOf(parameter));
  if (parameter.name != "omit" || text != "none") Refuse(parameter.FullName() + " " + text);
}

void RefuseWhatItCannotDo(const plan::Scene& scene) {
  for (const schema::Parameter& parameter : schema::Schema()) {
    RequireDefault(parameter, scene.world);
    for (const plan::Group& group : scene.groups) RequireDefault(parameter, group.settings);
  }
  for (const auto& word : scene.world.Words("record"))
    if (word != "timing" && word != "counts") Refuse("record " + std::string(word));
  for (const auto& word : scene.world.Words("accuracy.metrics"))
    if (!schema::ListsWord("none position velocity orientation energy", word))
      Refuse("accuracy.metrics " + std::string(word));
  if (scene.role != plan::Role::kMeasured || scene.world.On("sleeping"))
    throw std::runtime_error("the ODE worker needs 'sleeping off' and an error with a closed form");
}

class World {
 public:
  World(const plan::Scene& scene, const layouts::InitialState& state) : state_(state) {
    timestep_ = scene.world.Real("timestep");
    friction_ = scene.world.Real("world.wall_friction");
    restitution_ = scene.world.Real("world.wall_restitution");
    const Vector3d& g = state.acceleration;
    dWorldSetGravity(world_, g.x(), g.y(), g.z());
    dWorldSetERP(world_, scene.world.Real("solver.erp"));
    dWorldSetQuickStepNumIterations(world_,
                                    static_cast<int>(scene.world.Count("solver.iterations")));
    space_ = MakeSpace(scene.world.WordOr("detector"));
    for (const layouts::ObjectState& object : state.objects) Add(object);
    const std::string_view walls = scene.world.WordOr("world.walls");
    const double half = scene.world.Real("world.side") / 2;
    for (int axis = 0; axis < 3; ++axis)
      for (const int side : {1, -1})
        if (walls == "all" || (walls == "floor" && axis == 1 && side == 1))
          dCreatePlane(space_, axis == 0 ? side : 0, axis == 1 ? side : 0, axis == 2 ? side : 0,
                       -half);
  }
  World(const World&) = delete;
  World& operator=(const World&) = delete;
  ~World() {
    dJointGroupDestroy(contact_joints_);
    dSpaceDestroy(space_);
    dWorldDestroy(world_);
  }

  /// One cycle; ODE solves and integrates in one call, so that these two are not told apart.
  struct Times {
    double broad, narrow, step;
  };
  Times Step() {
    pairs_.clear();
    contacts_ = 0;
    const double begin = Now();
    dSpaceCollide(space_, &pairs_, [](void* pairs, dGeomID a, dGeomID b) {
      if (dGeomGetBody(a) != nullptr || dGeomGetBody(b) != nullptr)
        static_cast<std::vector<std::pair<dGeomID, dGeomID>>*>(pairs)->emplace_back(a, b);
    });
    const double listed = Now();
    for (const auto& [a, b] : pairs_) Collide(a, b);
    const double found = Now();
    dWorldQuickStep(world_, timestep_);
    dJointGroupEmpty(contact_joints_);
    return {listed - begin, found - listed, Now() - begin};
  }
  int pairs() const { return static_cast<int>(pairs_.size()); }
  int contacts() const { return contacts_; }

  struct Motion {
    Vector3d position;
    Eigen::Quaterniond orientation;
    Vector3d velocity, spin;
  };
  Motion MotionOf(std::size_t object) const {
    const layouts::ObjectState& start = state_.objects[object];
    if (bodies_[object] == nullptr)
      return {start.pose.position, start.pose.orientation, Vector3d::Zero(), Vector3d::Zero()};
    const dReal* q = dBodyGetQuaternion(bodies_[object]);
    const auto vector = [](const dReal* v) { return Vector3d(v[0], v[1], v[2]); };
    return {vector(dBodyGetPosition(bodies_[object])),
            {q[0], q[1], q[2], q[3]},
            vector(dBodyGetLinearVel(bodies_[object])),
            vector(dBodyGetAngularVel(bodies_[object]))};
  }

 private:
  static dSpaceID MakeSpace(std::string_view detector) {
    if (detector == "simple") return dSimpleSpaceCreate(nullptr);
    if (detector == "ode_sap") return dSweepAndPruneSpaceCreate(nullptr, dSAP_AXES_XYZ);
    if (detector == "ode_hash") return dHashSpaceCreate(nullptr);
    throw std::runtime_error(
        "the ODE worker has the detectors simple, ode_sap and ode_hash, and not '" +
        std::string(detector) + "'");
  }

  void Add(const layouts::ObjectState& object) {
    const Vector3d& sides = object.solid.sides;
    dGeomID geom = nullptr;
    if (object.solid.IsBall()) geom = dCreateSphere(space_, sides.x() / 2);
    if (object.solid.shape == objects::Shape::kCuboid)
      geom = dCreateBox(space_, sides.x(), sides.y(), sides.z());
    if (geom == nullptr || object.is_kinematic)
      throw std::runtime_error("the ODE worker knows balls and cuboids, and nothing kinematic");
    dGeomSetData(geom, const_cast<layouts::ObjectState*>(&object));
    dBodyID body = nullptr;
    if (!object.IsFixed()) {
      body = dBodyCreate(world_);
      const Vector3d inertia = object.mass * object.solid.InertiaPerMass();
      dMass mass;
      dMassSetParameters(&mass, object.mass, 0, 0, 0, inertia.x(), inertia.y(), inertia.z(), 0, 0,
                         0);
      dBodySetMass(body, &mass);
      dBodySetLinearVel(body, object.linear_velocity.x(), object.linear_velocity.y(),
                        object.linear_velocity.z());
      dBodySetAngularVel(body, object.angular_velocity.x(), object.angular_velocity.y(),
                         object.angular_velocity.z());
      dGeomSetBody(geom, body);
    }
    const Vector3d& x = object.pose.position;
    const Eigen::Quaterniond& q = object.pose.orientation;
    const dQuaternion turn = {q.w(), q.x(), q.y(), q.z()};
    dGeomSetPosition(geom, x.x(), x.y(), x.z());
    dGeomSetQuaternion(geom, turn);
    bodies_.push_back(body);
  }

  /// Friction and restitution as Bullet combines them: the product of both bodies' coefficients.
  void Collide(dGeomID a, dGeomID b) {
    constexpr int kMostPoints = 8;
    dContact points[kMostPoints];
    const int count = dCollide(a, b, kMostPoints, &points[0].geom, sizeof(dContact));
    const auto* first = static_cast<const layouts::ObjectState*>(dGeomGetData(a));
    const auto* second = static_cast<const layouts::ObjectState*>(dGeomGetData(b));
    for (int i = 0; i < count; ++i) {
      points[i].surface = {};
      points[i].surface.mode = dContactApprox1;
      points[i].surface.mu = (first ? first->numbers["friction"] : friction_) *
                             (second ? second->numbers["friction"] : friction_);
      const double bounce = (first ? first->numbers["restitution"] : restitution_) *
                            (second ? second->numbers["restitution"] : restitution_);
      if (bounce > 0) points[i].surface.mode |= dContactBounce;
      points[i].surface.bounce = bounce;
      dJointAttach(dJointCreateContact(world_, contact_joints_, &points[i]), dGeomGetBody(a),
                   dGeomGetBody(b));
    }
    contacts_ += count;
  }

  const layouts::InitialState& state_;
  dWorldID world_ = dWorldCreate();
  dSpaceID space_ = nullptr;
  dJointGroupID contact_joints_ = dJointGroupCreate(0);
  double timestep_ = 0;
  double friction_ = 0, restitution_ = 0;  ///< of the walls
  std::vector<dBodyID> bodies_;            ///< null where the object is fixed
  std::vector<std::pair<dGeomID, dGeomID>> pairs_;
  int contacts_ = 0;
};

/// States of all objects, which the runner compares with the closed form. Without a clock, in a
/// pass of its own.
void TakeSample(const World& world, const layouts::InitialState& state,
                const protocol::SampleShape& shape, std::size_t sample, std::span<double> values) {
  double kinetic = 0, potential = 0;
  for (std::size_t i = 0; i < state.objects.size(); ++i) {
    const layouts::ObjectState& object = state.objects[i];
    const auto [x, q, v, w] = world.MotionOf(i);
    Eigen::Map<Eigen::Matrix<double, protocol::kStateSize, 1>>(&values[shape.State(sample, i)])
        << x,
        q.coeffs(), v, w;
    values[shape.Body(i)] = object.mass;
    values[shape.Body(i) + 1] = object.solid.sides.maxCoeff();
    const Vector3d turn = q.conjugate() * w;
    kinetic +=
        object.mass / 2 * (v.squaredNorm() + turn.cwiseAbs2().dot(object.solid.InertiaPerMass()));
    potential -= object.mass * state.acceleration.dot(x);
  }
  double* observables = &values[shape.Observables(sample)];
  observables[protocol::kKinetic] = kinetic;
  observables[protocol::kPotential] = potential;
  Eigen::Map<Vector3d>{observables + protocol::kAccelerationX} = state.acceleration;
}

void RunWithClock(const plan::Scene& scene, const layouts::InitialState& state,
                  protocol::Recording& recording) {
  World world(scene, state);
  const auto durations = recording.Reals("duration");
  const auto pairs = recording.Ints("pairs"), contacts = recording.Ints("contacts");
  const std::size_t cycles = scene.world.Count("cycles");
  for (std::uint64_t i = scene.world.Count("warmup"); i > 0; --i) world.Step();
  for (std::size_t cycle = 0; cycle < cycles; ++cycle) {
    const auto [broad, narrow, step] = world.Step();
    const std::pair<int, double> phases[] = {
        {0, broad}, {1, narrow}, {2, broad + narrow}, {5, step}};
    if (!durations.empty())
      for (const auto& [phase, ns] : phases)
        durations[static_cast<std::size_t>(phase) * cycles + cycle] = ns;
    if (!pairs.empty()) pairs[cycle] = world.pairs();
    if (!contacts.empty()) contacts[cycle] = world.contacts();
    recording.header().cycles_done.store(cycle + 1, std::memory_order_release);
  }
}

void RunForErrors(const plan::Scene& scene, const layouts::InitialState& state,
                  protocol::Recording& recording) {
  const auto shape = protocol::SampleShapeOf(scene);
  if (!shape) return;
  World world(scene, state);
  const std::size_t cycles_per_sample = analysis::SamplingOf(scene)->cycles;
  for (std::size_t sample = 0; sample < shape->samples; ++sample) {
    for (std::size_t i = 0; sample > 0 && i < cycles_per_sample; ++i) world.Step();
    TakeSample(world, state, *shape, sample, recording.SampleValues());
  }
}

/// The exit status: 0 where the recording says how the run ended.
int Execute(const std::vector<std::string>&) {
  protocol::BindToRunner();
  const plan::Run run = yaml::RunFromYaml(protocol::ReadAll(protocol::kRunFd), "run");
  protocol::Recording recording = protocol::Recording::Open(protocol::kRecordingFd, run.scene);
  protocol::RecordingHeader& header = recording.header();
  try {
    if (!dCheckConfiguration("ODE_double_precision"))
      throw std::runtime_error("this ODE counts in float");
    RefuseWhatItCannotDo(run.scene);
    dInitODE();
    const double begin = Now();
    const layouts::InitialState state = layouts::MakeInitialState(run.scene);
    header.scalars.fill_fraction = state.fill_fraction;
    header.scalars.place_ns = Now() - begin;
    RunWithClock(run.scene, state, recording);
    struct rusage usage = {};
    getrusage(RUSAGE_SELF, &usage);
    header.scalars.peak_rss_bytes = 1024.0 * static_cast<double>(usage.ru_maxrss);
    RunForErrors(run.scene, state, recording);
    header.outcome.store(protocol::WorkerOutcome::kDone, std::memory_order_release);
  } catch (const std::exception& error) {
    header.message = error.what();
    header.outcome.store(protocol::WorkerOutcome::kFailed, std::memory_order_release);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  // Workers are forked from one that is loaded.
  if (argc == 2 && argv[1] == std::string_view(protocol::kServeOption))
    protocol::ServeForks(Execute);
  return Execute({});
}
