#include "impedraw/arm/urdf_flange.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>

#include <fmt/format.h>

#include "impedraw/common/errors.h"

namespace impedraw {

namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr int kFewest = 6;
constexpr double kAligned = 0.99;  // cosine
const char* const kNames[] = {"tool0",        "tcp",  "flange", "eef",    "ee_link",
                              "end_effector", "tool", "hand",   "gripper"};

bool has(std::string name, const char* part) {
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name.find(part) != name.npos;
}

bool of_gripper(const UrdfElement* joint) {
  const std::string all = name_of(joint) + " " + child_of(joint);
  return !is_driven(joint) || type_of(joint) == "prismatic" || has(all, "finger") ||
         has(all, "gripper") || has(all, "knuckle") || has(all, "jaw");
}

// What is fixed to a link, itself first, and the joints that move what hangs there.
struct Region {
  std::vector<std::string> links;
  std::vector<UrdfElement*> moving;
};

Region region_of(const UrdfTree& tree, const std::string& root) {
  Region region{{root}, {}};
  for (std::size_t i = 0; i < region.links.size() && i < tree.links.size(); ++i)
    for (UrdfElement* joint : tree.joints) {
      if (parent_of(joint) != region.links[i]) continue;
      if (type_of(joint) == "fixed")
        region.links.push_back(child_of(joint));
      else
        region.moving.push_back(joint);
    }
  return region;
}

std::vector<Region> arm_ends(const UrdfTree& tree) {
  std::vector<Region> ends;
  const std::function<void(const std::string&, int, int)> visit = [&](const std::string& root,
                                                                      int joints, int depth) {
    Region here = region_of(tree, root);
    const bool gripper = here.moving.size() != 1 || of_gripper(here.moving[0]);
    if (joints >= kFewest && gripper) {
      ends.push_back(std::move(here));
    } else if (depth < static_cast<int>(tree.links.size())) {
      for (const UrdfElement* joint : here.moving)
        visit(child_of(joint), joints + (is_driven(joint) ? 1 : 0), depth + 1);
    }
  };
  for (const UrdfElement* link : tree.links)
    if (!tree.to.contains(name_of(link))) visit(name_of(link), 0, 0);
  return ends;
}

// By its name; empty: none has one, and there are several.
std::string clear_flange(const Region& end) {
  for (const char* part : kNames)
    for (const std::string& link : end.links)
      if (has(link, part)) return link;
  return end.links.size() == 1 ? end.links[0] : "";
}

// The last moved joint's axis in the link's frame, away from the arm.
Vector3d outwards(const UrdfTree& tree, const std::string& link) {
  Isometry3d X_LA = Isometry3d::Identity();  // A: of the links before it, where joints are at 0
  Vector3d axis = Vector3d::Zero();
  const std::vector<UrdfElement*> way = tree.way_to(link);
  for (auto at = way.rbegin(); at != way.rend(); ++at) {
    if (axis.isZero() && type_of(*at) != "fixed") {
      const auto* e = (*at)->FirstChildElement("axis");
      axis = X_LA.linear() * (e ? vector_of(e, "xyz") : Vector3d::UnitX()).normalized();
    }
    if (const double behind = -axis.dot(X_LA.translation()); std::abs(behind) > 1e-3)
      return behind > 0.0 ? axis : Vector3d(-axis);
    X_LA = X_LA * placement_of(*at).inverse();
  }
  return axis;
}

}  // namespace

std::vector<std::string> flange_candidates(const UrdfTree& tree) {
  std::vector<std::string> names;
  for (const Region& end : arm_ends(tree)) {
    const std::string link = clear_flange(end);
    if (link.empty())
      names.insert(names.end(), end.links.begin(), end.links.end());
    else
      names.push_back(link);
  }
  return names;
}

PenMount find_mount(const UrdfTree& tree, const std::string& flange) {
  const std::vector<std::string> candidates = flange_candidates(tree);
  const std::string listed = fmt::format("{}", fmt::join(candidates, ", "));
  PenMount mount{flange, Isometry3d::Identity(), {}};
  if (!flange.empty() && !tree.link.contains(flange))
    throw InputError(fmt::format("no link '{}'; --flange takes a link of the arm's end{}{}", flange,
                                 candidates.empty() ? "" : ": ", listed));
  if (flange.empty()) {
    if (candidates.empty())
      throw InputError(fmt::format(
          "it holds no arm of {} joints or more; --flange LINK names the link for the pen",
          kFewest));
    if (candidates.size() > 1)
      throw InputError(
          fmt::format("which link carries the pen is not clear; --flange takes one of "
                      "{}",
                      listed));
    mount.link = candidates[0];
  }
  const Vector3d out = outwards(tree, mount.link);
  if (!flange.empty() || out.z() > kAligned) {
    mount.notes.push_back(fmt::format("the pen stands on '{}', along its z", mount.link));
    if (out.z() < kAligned)
      mount.notes.push_back(
          fmt::format("that z is not the last joint's axis, which leaves the arm along ({:.2f}, "
                      "{:.2f}, {:.2f}) "
                      "of '{}'",
                      out.x(), out.y(), out.z(), mount.link));
  } else {
    mount.X_FM.rotate(z_along(out));
    mount.notes.push_back(fmt::format(
        "the pen stands on '{}', along the last joint's axis, ({:.2f}, {:.2f}, {:.2f}) of it",
        mount.link, out.x(), out.y(), out.z()));
  }
  return mount;
}

std::string put_mount(UrdfTree* tree, PenMount* mount) {
  // R: of the link that the last joint moves.
  const auto way_in_region = [tree](const std::string& link) {
    std::vector<UrdfElement*> way = tree->way_to(link);
    const auto last = std::find_if(way.rbegin(), way.rend(),
                                   [](const UrdfElement* j) { return type_of(j) != "fixed"; });
    way.erase(way.begin(), last.base());
    return way;
  };
  const auto pose_in_region = [](const std::vector<UrdfElement*>& way) {
    Isometry3d X_RL = Isometry3d::Identity();
    for (const UrdfElement* joint : way) X_RL = X_RL * placement_of(joint);
    return X_RL;
  };
  const std::vector<UrdfElement*> to_mount = way_in_region(mount->link);
  const Isometry3d X_MR = (pose_in_region(to_mount) * mount->X_FM).inverse();
  const std::string root = to_mount.empty() ? mount->link : parent_of(to_mount[0]);
  double reach = 0.0;
  for (const std::string& link : region_of(*tree, root).links) {
    // What carries F is no tool.
    if (std::any_of(to_mount.begin(), to_mount.end(),
                    [&link](const UrdfElement* j) { return parent_of(j) == link; }))
      continue;
    const Isometry3d X_ML = X_MR * pose_in_region(way_in_region(link));
    for (const auto* e = tree->link[link]->FirstChildElement("collision"); e;
         e = e->NextSiblingElement("collision")) {
      const auto* geometry = e->FirstChildElement("geometry");
      const auto* shape = geometry ? geometry->FirstChildElement() : nullptr;
      const Isometry3d X_MB = X_ML * placement_of(e);
      const double half = 0.5 * number_of(shape, "length", 0.0);
      reach = std::max(reach, X_MB.translation().z() + half * std::abs(X_MB.linear()(2, 2)) +
                                  number_of(shape, "radius", 0.0));
    }
  }
  if (reach > 0.0)
    mount->notes.push_back(fmt::format(
        "what the last joint carries reaches {:.0f} mm along the pen, which begins beyond it",
        1e3 * reach));
  if (reach == 0.0 && mount->link == "flange" && mount->X_FM.isApprox(Isometry3d::Identity()))
    return "flange";
  const std::string name = tree->link.contains("flange") ? "pen_mount" : "flange";
  auto* joint = tree->robot->InsertNewChildElement("joint");
  joint->SetAttribute("name", (name + "_joint").c_str());
  joint->SetAttribute("type", "fixed");
  joint->InsertNewChildElement("parent")->SetAttribute("link", mount->link.c_str());
  joint->InsertNewChildElement("child")->SetAttribute("link", name.c_str());
  Isometry3d X = mount->X_FM;
  X.translate(reach * Vector3d::UnitZ());
  set_placement(joint, X);
  tree->robot->InsertNewChildElement("link")->SetAttribute("name", name.c_str());
  return name;
}

}  // namespace impedraw
