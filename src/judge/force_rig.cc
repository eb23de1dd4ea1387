#include "impedraw/judge/force_rig.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "impedraw/run/loop_sources.h"

namespace impedraw {
namespace {

constexpr double kPeriod = 1e-3;  // [s]

}  // namespace

CanvasMotion motion_of(const ForceCase& c, const Workpiece& piece, double start) {
  if (!c.motion) return {};
  CanvasMotionSettings settings = *c.motion;
  settings.centre += piece.p_W;
  settings.start = start;
  return CanvasMotion(settings);
}

std::string rig_order(const ForceCase& c, const Workpiece& piece, const ForceProgramme& programme,
                      int number) {
  using nlohmann::json;
  const double start = programme.start();
  const CanvasMotion motion = motion_of(c, piece, start);
  const Disturbances hand =
      c.hand ? Disturbances(*c.hand, start + ForceProgramme::kHand) : Disturbances();
  json poses = json::array(), stiffness = json::array(), forces = json::array();
  const long last = std::lround((programme.leave() - start) / kPeriod);
  for (long i = 0; i <= last; ++i) {
    const double t = start + kPeriod * static_cast<double>(i);
    if (c.motion) {
      const Pose X = motion.at(t).X_WK;
      const Eigen::Quaterniond q(X.R);
      poses.push_back({X.p.x(), X.p.y(), X.p.z(), q.w(), q.x(), q.y(), q.z()});
    }
    if (c.stiffness) stiffness.push_back(c.stiffness_at(programme.share(t)));
    if (c.hand) {
      const Eigen::Vector3d F = hand.push(t, Eigen::Vector3d::UnitZ());
      forces.push_back({F.x(), F.y(), F.z()});
    }
  }
  return json{{"run", number},
              {"case", c.name},
              {"shape", Workpiece::kNames[static_cast<int>(c.shape)]},
              {"middle", {piece.p_W.x(), piece.p_W.y(), piece.p_W.z()}},
              {"start", start},
              {"end", programme.end()},
              {"leave", programme.leave()},
              {"period", kPeriod},
              {"poses", std::move(poses)},
              {"stiffness", std::move(stiffness)},
              {"hand", std::move(forces)}}
      .dump();
}

}  // namespace impedraw
