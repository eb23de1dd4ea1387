#include "impedraw/experiment/scene.h"

#include <algorithm>
#include <filesystem>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "impedraw/canvas/mesh_facing.h"
#include "impedraw/experiment/height_sources.h"
#include "impedraw/experiment/snapshot.h"
#include "impedraw/experiment/start_posture.h"
#include "impedraw/perception/axis_motion.h"
#include "impedraw/perception/canvas_tracker.h"
#include "impedraw/settings/yaml_write.h"

namespace impedraw {
namespace {

// one-sidedness: 2 mm within the rim of the standard bowl; the controller's 0.66 is 1 mm beyond it
constexpr double kEdgeOfPlanning = 0.5;

// Place of a mesh from a file that nobody has placed: under the drawing's centre, its lowest
// point just above the table, or lower if it is tall.
void put_in_reach(TriangleMesh* mesh, Scenario* s, std::vector<std::string>* notes) {
  constexpr double kFoot = 0.02, kTop = 0.35;  // [m]
  // A surface that a capture or a cloud shows stands where it stood.
  const bool captured = s->perception.source != PerceptionSource::simulated;
  if (s->canvas.kind != CanvasKind::mesh || !s->canvas.move.isZero() ||
      !s->drawing.tilt_deg.isZero() || captured)
    return;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : mesh->vertices) box.extend(p);
  const Eigen::Vector2d centre = s->drawing.placement.centre_m;
  const PerceptionSettings& seen = s->perception;
  const bool under = box.min().x() <= centre.x() && centre.x() <= box.max().x() &&
                     box.min().y() <= centre.y() && centre.y() <= box.max().y();
  const bool at_height =
      box.max().z() >= seen.region_lower.z() && box.max().z() <= seen.region_upper.z();
  if (under && at_height) return;
  const Eigen::Vector3d move(centre.x() - box.center().x(), centre.y() - box.center().y(),
                             std::min(kFoot, kTop - box.sizes().z()) - box.min().z());
  for (Eigen::Vector3d& p : mesh->vertices) p += move;
  s->canvas.move = move;
  notes->push_back(fmt::format(
      "the mesh lies out of reach; it was moved by ({:.3f}, {:.3f}, {:.3f}) m to under the "
      "drawing's centre (canvas.move places it elsewhere)",
      move.x(), move.y(), move.z()));
}

// Open parts whose front faces away from the drawing, as many scanners write them: cameras see them
// from behind as well as from the front, but their front alone would bear the pen.
void turn_to_drawing(TriangleMesh* mesh, const Scenario& s, const Eigen::Vector3d& z_WP,
                     std::vector<std::string>* notes) {
  if (s.canvas.kind != CanvasKind::mesh || s.canvas.mesh.side != MeshSettings::Side::outward)
    return;
  const int turned = turn_parts_seen_from_behind(mesh, z_WP);
  if (turned == 0) return;
  const bool all = turned == static_cast<int>(mesh->triangles.size());
  notes->push_back(
      all ? "the mesh is an open sheet whose front faces away from the drawing; it was turned, as "
            "by canvas.mesh.side: inward"
          : fmt::format("{} of the mesh's {} triangles, in open parts that show their back to the "
                        "drawing, were turned",
                        turned, mesh->triangles.size()));
}

// A square around each point of the seen surface, across its normal: squares of neighbours meet. Of
// a thing that is thinner than the cameras resolve, a wire for instance, they see a point here and
// there, apart from the surface that is fitted to its neighbours: its square faces the camera and
// is so large that a pen does not pass between two of them. Such a point has another one nearby;
// one that is alone is the depth's noise.
TriangleMesh seen_facets(const SurfaceEstimator& seen, double voxel) {
  constexpr double kApart = 5e-3, kApartHalf = 1e-2, kNearby = 0.025;  // [m]
  const double spacing = std::max(voxel, 0.004);                       // [m]
  const bool is_sparse = voxel == spacing;
  const PointCloud sparse = is_sparse ? seen.cloud() : thin(seen.cloud(), spacing);
  std::vector<SurfaceEstimate> estimates;
  if (is_sparse)
    estimates = seen.at_points();
  else
    for (const Eigen::Vector3d& p : sparse.points) estimates.push_back(seen.estimate(p));
  std::vector<Eigen::Vector3d> far;
  for (std::size_t i = 0; i < estimates.size(); ++i)
    if (std::abs(estimates[i].distance) > kApart) far.push_back(sparse.points[i]);
  TriangleMesh mesh;
  for (std::size_t i = 0; i < sparse.points.size(); ++i) {
    Eigen::Vector3d p = sparse.points[i];
    const SurfaceEstimate& estimate = estimates[i];
    Eigen::Vector3d n = (sparse.eyes[static_cast<std::size_t>(sparse.camera[i])] - p).normalized();
    const bool apart = std::abs(estimate.distance) > kApart &&
                       std::count_if(far.begin(), far.end(), [&p](const Eigen::Vector3d& other) {
                         return (other - p).norm() < kNearby;
                       }) > 1;
    if (estimate.status == SurfaceStatus::ok && !apart) {
      n = estimate.n_W;
      p -= estimate.distance * n;  // takes the noise out
    }
    const Eigen::Vector3d a = (apart ? kApartHalf : 0.6 * spacing) * n.unitOrthogonal(),
                          b = n.cross(a);
    const int first = static_cast<int>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {p - a - b, p + a - b, p + a + b, p - a + b});
    mesh.triangles.insert(mesh.triangles.end(), {Eigen::Vector3i(first, first + 1, first + 2),
                                                 Eigen::Vector3i(first, first + 2, first + 3)});
  }
  return mesh;
}

void append(const TriangleMesh& more, TriangleMesh* mesh) {
  const int shift = static_cast<int>(mesh->vertices.size());
  mesh->vertices.insert(mesh->vertices.end(), more.vertices.begin(), more.vertices.end());
  for (const Eigen::Vector3i& t : more.triangles) mesh->triangles.push_back(t.array() + shift);
}

// The middle of the drawing and places round it, on the canvas; of the default arm, which reaches
// them: none.
std::vector<Eigen::Vector3d> about_drawing(const Scenario& s,
                                           const std::shared_ptr<const Canvas>& canvas,
                                           const Pose& X_WP) {
  constexpr double kRadius = 0.1;  // [m]
  constexpr int kAround = 8;
  std::vector<Eigen::Vector3d> places;
  if (s.arm.urdf.empty()) return places;
  const SurfaceHeight height = canvas_height(canvas, X_WP);
  for (int i = -1; i < kAround; ++i) {
    Eigen::Vector2d p = s.drawing.placement.centre_m;
    if (i >= 0)
      p += kRadius *
           Eigen::Rotation2Dd(2.0 * i * std::numbers::pi / kAround).toRotationMatrix().col(0);
    if (const auto on = height(p.x(), p.y())) places.push_back(X_WP * on->p_P);
  }
  return places;
}

const std::vector<std::string> kHowSeen = {"perception.region_lower",
                                           "perception.region_upper",
                                           "perception.cameras",
                                           "perception.voxel",
                                           "perception.noise",
                                           "perception.source",
                                           "perception.capture",
                                           "perception.cloud",
                                           "perception.viewpoint",
                                           "perception",
                                           "canvas"};

void know_canvas(const Scenario& s, const Canvas& as_set_up, Snapshot snapshot, Belief* belief) {
  belief->perception = std::make_shared<const SurfaceEstimator>(std::move(snapshot.seen));
  belief->camera_corrections = std::move(snapshot.corrections);
  belief->planning = std::make_shared<const PlanSurface>(
      belief->perception, std::min(s.perception.normals.max_one_sidedness, kEdgeOfPlanning),
      s.preflight.roughest);
  TriangleMesh obstacle = seen_facets(*belief->perception, s.perception.voxel);
  if (snapshot.beside.points.size() >= static_cast<std::size_t>(s.perception.normals.k))
    append(seen_facets(SurfaceEstimator(std::move(snapshot.beside), s.perception.normals),
                       s.perception.voxel),
           &obstacle);
  // Beyond the region, which no camera is asked about, the canvas is where it was set up.
  append(outside_box(as_set_up.mesh(),
                     Eigen::AlignedBox3d(s.perception.region_lower, s.perception.region_upper)),
         &obstacle);
  belief->obstacle = std::make_shared<const Canvas>(std::move(obstacle));
}

// The canvas of which nothing is known but what was seen.
TriangleMesh seen_mesh(const Snapshot& snapshot, const Pose& X_WP) {
  // Does not outlive the snapshot.
  const std::shared_ptr<const SurfaceEstimator> seen(std::shared_ptr<void>(), &snapshot.seen);
  TriangleMesh mesh =
      surface_grid(perceived_height(seen, X_WP), snapshot.seen.cloud(), X_WP.inverse());
  if (mesh.triangles.empty())
    throw InputError(
        "what was seen makes no surface towards the drawing plane; valid is a capture or cloud in "
        "W, the arm's base, that shows the object within perception.region_lower and _upper, and a "
        "drawing.tilt that faces it");
  for (Eigen::Vector3d& p : mesh.vertices) p = X_WP * p;
  return mesh;
}

void check_source(const Scenario& s, const SettingErrors& setting_errors) {
  const bool rendered = s.perception.source == PerceptionSource::simulated;
  if (s.canvas.kind == CanvasKind::seen && (rendered || !s.perception.enabled))
    setting_errors.raise({"canvas.kind"},
                         "canvas.kind is seen, and nothing shows it; valid with perception.source "
                         "capture or cloud, and perception.enabled true");
  if (s.canvas.kind == CanvasKind::seen && (!s.canvas.move.isZero() || s.canvas.turn_deg != 0.0))
    setting_errors.raise({"canvas.move", "canvas.turn"},
                         "canvas.move and canvas.turn: a canvas of kind seen stands where it was "
                         "seen; valid is 0");
  if (s.arm.driver != ArmDriver::sim && s.perception.enabled && rendered && !s.canvas.true_model)
    setting_errors.raise(
        {"perception.source", "arm.driver"},
        "perception.source is simulated: it renders the canvas that is configured, and a driven "
        "arm need not have that before it; valid are capture or cloud, or canvas.true_model=true "
        "if the canvas stands there as configured");
}

// Dry friction reaches the tip as far as the observer lags behind it. Where the description has
// some, and no bandwidth is given, a faster observer takes it: the xArm7's 1 Nm cost 0.25 mm RMS at
// 200 rad/s and 0.13 at 600. A driven arm compensates its own friction.
void reckon_with_dynamics(const World& world, Scenario* s, std::vector<std::string>* notes) {
  constexpr double kFaster = 600.0;  // [rad/s]
  const double damping = world.damping().maxCoeff() - s->world.errors.viscous_friction,
               friction = world.dry_friction().maxCoeff() - s->world.joint_friction;
  if (std::max(damping, friction) <= 1e-9) return;
  std::optional<double>& bandwidth = s->control.observer.bandwidth;
  const bool faster = friction > 1e-9 && s->arm.driver == ArmDriver::sim && !bandwidth;
  if (faster) bandwidth = kFaster;
  notes->push_back(fmt::format(
      "the arm's description gives joints a damping of up to {:.3g} Nm s/rad and a friction of "
      "up to {:.3g} Nm: the simulated arm has both, the controller's model the damping{}",
      std::max(0.0, damping), std::max(0.0, friction),
      faster ? fmt::format("; control.observer.bandwidth is {:.0f} rad/s for the friction", kFaster)
             : ""));
}

void check_pushes(const Scenario& s, const World& world, const SettingErrors& setting_errors) {
  for (const PushSettings& push : s.pushes) {
    if (push.link.empty()) continue;
    const std::optional<int> link = world.link(push.link);
    if (link && !world.below_flange(*link)) continue;
    setting_errors.raise(
        {"pushes"},
        fmt::format("pushes: link is {}; valid are the links of the arm above its flange, or none "
                    "for a push on the pen",
                    push.link));
  }
}

void check_frames(const Scenario& s, const SettingErrors& setting_errors) {
  if (!s.perception.frames.enabled) return;
  setting_errors.locate({"perception.frames"}, [&] {
    if (!s.perception.enabled)
      throw InputError(
          "perception.frames.enabled: without perception there are no cameras; valid is false, or "
          "perception.enabled true");
    const FrameSettings& frames = s.perception.frames;
    if (s.perception.source == PerceptionSource::capture && !frames.depth)
      throw InputError(
          "perception.frames.depth: the frames of a capture have depths alone; valid is true");
    const double most = BandLimited::kSpan - 2.0 * frames.latency_jitter;
    if (frames.latency > most)
      throw InputError(fmt::format(
          "perception.frames.latency: {:.3g} s, with {:.3g} s of jitter; the canvas's motion can "
          "be "
          "predicted across {:.3g} s, so that valid is up to {:.3g} s",
          frames.latency, frames.latency_jitter, BandLimited::kSpan, std::max(0.0, most)));
  });
  // By its shape alone, a canvas is found without marks.
  if (s.perception.frames.depth && s.perception.fiducials.points.empty()) return;
  setting_errors.locate({"perception.fiducials"},
                        [&] { CanvasTracker{CanvasTrackerSettings{s.perception.fiducials}}; });
}

CanvasMotion canvas_motion(const Scenario& s) {
  CanvasMotionSettings settings = s.canvas.motion;
  settings.seed = static_cast<std::uint64_t>(s.seed);
  return CanvasMotion(settings);
}

}  // namespace

void check_scene(const Scenario& s, const Scene& scene, const SettingErrors& setting_errors) {
  check_joint_settings(s, urdf_of(s.arm), scene.belief.arm, setting_errors);
  check_pushes(s, *scene.truth.world, setting_errors);
  check_frames(s, setting_errors);
}

JointVector start_before(Scenario& s, const Pose& X_WP, const Truth& truth, Belief* belief,
                         const SettingErrors& setting_errors) {
  const auto touching = [&truth](const JointVector& q) {
    truth.world->set_state(q, JointVector::Zero(q.size()));
    return truth.world->touching_link();
  };
  return start_posture(s.arm, belief->arm, X_WP, about_drawing(s, truth.canvas, X_WP),
                       setting_errors, touching, &belief->notes);
}

Scene build_scene(Scenario& s, const Pose& X_WP, const SettingErrors& setting_errors, bool placed) {
  std::vector<std::string> notes;
  check_source(s, setting_errors);
  // The arm model comes before the world: its reader names the joint or link that is at fault.
  const std::filesystem::path urdf = urdf_of(s.arm);
  ArmModel arm =
      setting_errors.locate({"arm.rotor_inertia", "arm.urdf"}, [&] { return model_of(s.arm); });
  if (s.tool.kind == ToolKind::nozzle) arm.lengthen_pen(s.tool.stand_off);
  std::optional<Snapshot> read;
  if (s.perception.enabled && s.perception.source != PerceptionSource::simulated)
    setting_errors.locate(kHowSeen,
                          [&] { read.emplace(read_snapshot(s, X_WP, placed, arm, &notes)); });
  const char* given = s.canvas.kind == CanvasKind::mesh ? "canvas.mesh.file" : "canvas";
  auto canvas = setting_errors.locate({given, "canvas"}, [&] {
    if (s.canvas.kind == CanvasKind::seen) return std::make_shared<Canvas>(seen_mesh(*read, X_WP));
    TriangleMesh mesh = make_mesh(s.canvas, &notes);
    put_in_reach(&mesh, &s, &notes);
    turn_to_drawing(&mesh, s, X_WP.R.col(2), &notes);
    return std::make_shared<Canvas>(std::move(mesh));
  });
  if (is_rehearsal(s))
    notes.emplace_back(
        "rehearsal: the simulated arm draws on a surface that is made of what was seen, holes "
        "included; ink and force are judged against that, not against the real object");
  check_joint_settings(s, urdf, arm, setting_errors);
  WorldSettings settings = s.world;
  settings.pad = face_of(s);
  if (settings.pad && is_led(s.tool)) {
    settings.pad->stiffness *= s.tool.hardness;
    settings.pad->damping *= s.tool.hardness;
  }
  settings.cutter = cutter_of(s.tool);
  if (settings.cutter) settings.cutter->hardness = s.tool.hardness;
  settings.flange_sensor = has_sensor(s.control.source);
  if (settings.errors.rotor_inertia.empty() && !settings.joint_spring.on())
    settings.errors.rotor_inertia.assign(arm.rotor_inertia().begin(), arm.rotor_inertia().end());
  auto world =
      setting_errors.locate({"world.joint_spring", "world.errors.rotor_inertia", "arm.urdf"},
                            [&] { return std::make_unique<World>(urdf, canvas.get(), settings); });
  if (s.tool.kind == ToolKind::nozzle) {
    world->set_tip(true_tip(s));
    world->set_pen_longer(s.world.errors.pen_longer + s.tool.stand_off);
  }
  reckon_with_dynamics(*world, &s, &notes);
  setting_errors.locate({"canvas.motion"}, [&] { world->move_canvas(canvas_motion(s)); });
  check_pushes(s, *world, setting_errors);
  check_frames(s, setting_errors);
  Scene scene{.belief = {.arm = std::move(arm),
                         .start_q = {},
                         .perception = {},
                         .planning = {},
                         .surface = {},
                         .obstacle = canvas,
                         .blind = s.blind,
                         .notes = std::move(notes),
                         .camera_corrections = {}},
              .truth = {std::move(canvas), std::move(world)}};
  Belief& belief = scene.belief;
  const Truth& truth = scene.truth;
  belief.start_q = start_before(s, X_WP, truth, &belief, setting_errors);
  if (s.perception.enabled && !read)
    setting_errors.locate(kHowSeen, [&] {
      read.emplace(
          take_snapshot(s, *truth.canvas, *truth.world, belief.arm, belief.start_q, &belief.notes));
    });
  if (read) know_canvas(s, *truth.canvas, std::move(*read), &belief);
  if (belief.planning)
    belief.surface = perceived_height(belief.planning, X_WP);
  else
    belief.surface = s.blind.height == BlindHeight::canvas ? canvas_height(belief.obstacle, X_WP)
                                                           : level_surface(s.blind.top_z);
  return scene;
}

namespace {

std::string stamp_of(const std::filesystem::path& file) {
  std::error_code error;
  return fmt::format("{} {} {}\n", file.string(), std::filesystem::file_size(file, error),
                     std::filesystem::last_write_time(file, error).time_since_epoch().count());
}

// The text of all settings that build_scene() reads, and the state of its files.
std::string made_of(const Scenario& s) {
  Scenario read;
  read.canvas = s.canvas;
  read.arm = s.arm;
  read.perception = s.perception;
  read.world = s.world;
  read.blind = s.blind;
  read.tool = s.tool;
  if (face_of(s)) read.control.normal_force = s.control.normal_force;
  read.drawing.tilt_deg = s.drawing.tilt_deg;
  std::string files = stamp_of(urdf_of(s.arm));
  // A mesh may be put under the drawing's centre, and an arm starts where it leads there.
  const bool found = s.perception.source != PerceptionSource::simulated;
  if (found) read.drawing.placement = s.drawing.placement;
  if (s.canvas.kind == CanvasKind::mesh || !s.arm.urdf.empty())
    read.drawing.placement.centre_m = s.drawing.placement.centre_m;
  if (s.canvas.kind == CanvasKind::mesh) files += stamp_of(s.canvas.mesh.file);
  if (s.perception.source == PerceptionSource::capture)
    files += stamp_of(s.perception.capture / "capture.json");
  if (s.perception.source == PerceptionSource::cloud) files += stamp_of(s.perception.cloud);
  if (!s.canvas.motion.file.empty()) files += stamp_of(s.canvas.motion.file);
  read.control.source = s.control.source;  // of the wrench: the world measures it or not
  // Without noise and errors of the cameras, the snapshot has nothing to draw by lot.
  const DepthNoise& noise = s.perception.noise;
  const bool exact = noise.sigma_at_1m == 0.0 && s.perception.errors.shift == 0.0 &&
                     s.perception.errors.turn_deg == 0.0 && !s.perception.stereo;
  read.seed = exact || !s.perception.enabled ? 0 : s.seed;
  return settings_yaml(read) + files;
}

}  // namespace

Scene SceneCache::take(Scenario& s, const Pose& X_WP, const SettingErrors& setting_errors) {
  made_of_ = made_of(s);
  const auto found = std::find_if(kept_.begin(), kept_.end(),
                                  [&](const Kept& kept) { return kept.made_of == made_of_; });
  if (found == kept_.end()) {
    Scene scene = build_scene(s, X_WP, setting_errors);
    move_ = s.canvas.move;
    start_ = s.arm.start_p_WE;
    ++built_;
    return scene;
  }
  check_scene(s, found->scene, setting_errors);
  Scene scene = std::move(found->scene);
  move_ = s.canvas.move = found->move;
  start_ = s.arm.start_p_WE = found->start;
  kept_.erase(found);
  const Belief& belief = scene.belief;
  scene.truth.world->set_state(belief.start_q, JointVector::Zero(belief.arm.joints()));
  ++reused_;
  return scene;
}

void SceneCache::give_back(Scene scene) {
  kept_.push_front({made_of_, move_, start_, std::move(scene)});
  if (kept_.size() > most_) kept_.pop_back();
}

}  // namespace impedraw
