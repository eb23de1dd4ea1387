#include "impedraw/arm/urdf_tree.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <fmt/format.h>
#include <urdf_model/pose.h>

#include "impedraw/arm/urdf_text.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/input_file.h"

namespace impedraw {

UrdfTree::UrdfTree(const std::filesystem::path& file) {
  require_urdf_file(file);
  const std::string xml = InputFile(file).read(4'000'000);
  if (document.Parse(xml.data(), xml.size()) != tinyxml2::XML_SUCCESS)
    throw InputError(fmt::format("not valid XML: {}", document.ErrorStr()));
  links = all(document.RootElement(), "link");
  joints = all(document.RootElement(), "joint");
}

UrdfElement* UrdfTree::link(const std::string& name) const {
  for (UrdfElement* link : links)
    if (value(link, "name") == name) return link;
  return nullptr;
}

UrdfElements UrdfTree::way_to(const std::string& link) const {
  UrdfElements way;
  std::string at = link;
  while (way.size() < joints.size()) {  // a loop in the tree ends, too
    const auto joint = std::find_if(joints.begin(), joints.end(),
                                    [&at](const auto* j) { return child_of(j) == at; });
    if (joint == joints.end()) break;
    way.insert(way.begin(), *joint);
    at = parent_of(*joint);
  }
  return way;
}

std::string UrdfTree::text() const {
  tinyxml2::XMLPrinter printer;
  document.Print(&printer);
  return printer.CStr();
}

UrdfElements all(UrdfElement* in, const char* name) {
  UrdfElements found;
  for (auto* e = in->FirstChildElement(name); e; e = e->NextSiblingElement(name))
    found.push_back(e);
  return found;
}

std::string value(const UrdfElement* e, const char* attribute) {
  const char* text = e ? e->Attribute(attribute) : nullptr;
  return text ? text : "";
}
double number(const UrdfElement* e, const char* attribute) {
  return e ? e->DoubleAttribute(attribute) : 0.0;
}
std::string parent_of(const UrdfElement* joint) {
  return value(joint->FirstChildElement("parent"), "link");
}
std::string child_of(const UrdfElement* joint) {
  return value(joint->FirstChildElement("child"), "link");
}
bool is_type(const UrdfElement* joint, const char* type) { return joint->Attribute("type", type); }

Eigen::Vector3d vector(const UrdfElement* e, const char* attribute, double otherwise) {
  if (value(e, attribute).empty()) return Eigen::Vector3d::Constant(otherwise);
  urdf::Vector3 v;
  v.init(value(e, attribute));
  return {v.x, v.y, v.z};
}
Eigen::Vector3d axis_of(const UrdfElement* joint) {
  const auto* axis = joint->FirstChildElement("axis");
  return axis ? vector(axis, "xyz", 0.0).normalized() : Eigen::Vector3d::UnitX();
}

Eigen::Isometry3d placement_of(const UrdfElement* e) {
  const auto* origin = e->FirstChildElement("origin");
  const Eigen::Vector3d rpy = vector(origin, "rpy", 0.0);
  urdf::Rotation r;
  r.setFromRPY(rpy.x(), rpy.y(), rpy.z());
  Eigen::Isometry3d X(Eigen::Quaterniond(r.w, r.x, r.y, r.z));
  X.pretranslate(vector(origin, "xyz", 0.0));
  return X;
}

void set_placement(UrdfElement* e, const Eigen::Isometry3d& X) {
  auto* origin = e->FirstChildElement("origin");
  if (!origin) origin = e->InsertNewChildElement("origin");
  const Eigen::Vector3d p = X.translation();
  const Eigen::Quaterniond q(X.linear());
  urdf::Rotation r;
  r.setFromQuaternion(q.x(), q.y(), q.z(), q.w());
  double roll = 0.0, pitch = 0.0, yaw = 0.0;
  r.getRPY(roll, pitch, yaw);
  origin->SetAttribute("xyz", fmt::format("{:.12g} {:.12g} {:.12g}", p.x(), p.y(), p.z()).c_str());
  origin->SetAttribute("rpy", fmt::format("{:.12g} {:.12g} {:.12g}", roll, pitch, yaw).c_str());
}

void fix_link(UrdfTree* tree, const std::string& to, const Eigen::Isometry3d& X,
              const std::string& name) {
  auto* joint = tree->document.RootElement()->InsertNewChildElement("joint");
  joint->SetAttribute("name", (name + "_joint").c_str());
  joint->SetAttribute("type", "fixed");
  joint->InsertNewChildElement("parent")->SetAttribute("link", to.c_str());
  joint->InsertNewChildElement("child")->SetAttribute("link", name.c_str());
  set_placement(joint, X);
  tree->document.RootElement()->InsertNewChildElement("link")->SetAttribute("name", name.c_str());
}

std::vector<ArmEnd> arm_ends(const UrdfTree& tree) {
  std::vector<ArmEnd> ends;
  const std::function<void(UrdfElement*, int, std::size_t)> visit = [&](UrdfElement* root,
                                                                        int joints,
                                                                        std::size_t depth) {
    ArmEnd here{{root}, {Eigen::Isometry3d::Identity()}};
    if (const UrdfElements way = tree.way_to(value(root, "name")); !way.empty())
      here.axis = axis_of(way.back());
    UrdfElements moving;
    for (std::size_t i = 0; i < here.links.size() && i < tree.links.size(); ++i)
      for (UrdfElement* joint : tree.joints) {
        UrdfElement* child = tree.link(child_of(joint));
        if (!child || parent_of(joint) != value(here.links[i], "name")) continue;
        if (!is_type(joint, "fixed")) {
          moving.push_back(joint);
        } else {
          here.chain = here.chain && i + 1 == here.links.size();
          here.X_RL.push_back(here.X_RL[i] * placement_of(joint));
          here.links.push_back(child);
        }
      }
    const auto named = [](const UrdfElement* joint, const std::vector<const char*>& parts) {
      std::string names = value(joint, "name") + child_of(joint);
      for (char& c : names) c = static_cast<char>(std::tolower(c));
      return std::any_of(parts.begin(), parts.end(),
                         [&](const char* part) { return names.find(part) != names.npos; });
    };
    const auto of_gripper = [&](const UrdfElement* joint) {
      return is_type(joint, "prismatic") || joint->FirstChildElement("mimic") ||
             named(joint, {"finger", "jaw", "gripper"});
    };
    if (joints >= 6 && (moving.size() != 1 || of_gripper(moving[0])))
      ends.push_back(std::move(here));
    else if (depth < tree.joints.size())
      for (UrdfElement* joint : moving)
        if (!named(joint, {"finger", "jaw"}))
          visit(tree.link(child_of(joint)), joints + !joint->FirstChildElement("mimic"), depth + 1);
  };
  for (UrdfElement* link : tree.links)
    if (tree.way_to(value(link, "name")).empty()) visit(link, 0, 0);
  return ends;
}

namespace {

// The furthest frame on the last joint's axis that is nothing but a frame; empty: there is none.
std::string bare_frame(const ArmEnd& end) {
  constexpr double kOnAxis = 1e-3;  // [m]
  std::string furthest;
  double most = 0.0;
  for (std::size_t i = 0; i < end.links.size(); ++i) {
    const Eigen::Vector3d p = end.X_RL[i].translation();
    const double along = std::abs(end.axis.dot(p));
    if (!end.links[i]->NoChildren() || end.axis.cross(p).norm() > kOnAxis) continue;
    if (!furthest.empty() && along <= most) continue;
    furthest = value(end.links[i], "name");
    most = along;
  }
  return furthest;
}

}  // namespace

std::vector<std::string> flange_candidates(const std::vector<ArmEnd>& ends) {
  std::vector<std::string> candidates;
  for (const ArmEnd& end : ends) {
    std::string best;
    for (const char* part :
         {"tool0", "tcp", "flange", "eef", "ee_link", "end_effector", "tool", "hand", "gripper"})
      for (const UrdfElement* link : end.links)
        if (best.empty() && value(link, "name").find(part) != std::string::npos)
          best = value(link, "name");
    if (best.empty() && !end.chain) best = bare_frame(end);
    if (!best.empty())
      candidates.push_back(best);
    else
      for (const UrdfElement* link : end.links) candidates.push_back(value(link, "name"));
  }
  return candidates;
}

}  // namespace impedraw
