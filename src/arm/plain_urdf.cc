#include "impedraw/arm/plain_urdf.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <Eigen/Eigenvalues>

#include "impedraw/arm/enclosing_capsules.h"
#include "impedraw/arm/urdf_inertia.h"
#include "impedraw/arm/urdf_tree.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/rotations.h"

namespace impedraw {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
namespace fs = std::filesystem;

constexpr double kBodyRadius = 0.06;         // in place of a mesh [m]
constexpr double kMass = 1.0, kBall = 0.05;  // of a link without [kg], [m]
// Less than these, a plane body's inertia and a tiny one fail in MuJoCo by its rounding.
constexpr double kSlack = 1e-9, kLeastMoment = 1e-12;  // of the largest moment; [kg m²]
constexpr double kRounding = 1e-3;    // of the largest moment: digits that a file left out
constexpr double kLeastLimit = 0.01;  // of effort and velocity: a way would take hours
constexpr double kLeastAxis = 1e-6, kMostDynamics = 1e4;

std::string name_of(const UrdfElement* e) { return value(e, "name"); }

// Vendors' base links have boxes of 0 × 0 × 0.
bool has_no_size(const UrdfElement* shape) {
  const std::string kind = shape->Name();
  if (kind == "box") return vector(shape, "size", 0.0).isZero(0.0);
  return (kind == "sphere" || kind == "cylinder" || kind == "capsule") &&
         number(shape, "radius") == 0.0 && number(shape, "length") == 0.0;
}

// A capsule as a link's collision body.
void add_body(UrdfElement* link, const Capsule& c) {
  auto* collision = link->InsertNewChildElement("collision");
  const double length = std::max(1e-4, (c.b - c.a).norm());
  Isometry3d X(turn_between(Vector3d::UnitZ(), c.b - c.a));
  if ((c.b - c.a).norm() < 1e-9) X.setIdentity();
  set_placement(collision, X.pretranslate(0.5 * (c.a + c.b)));
  auto* shape = collision->InsertNewChildElement("geometry")->InsertNewChildElement("capsule");
  shape->SetAttribute("radius", fmt::format("{:.6g}", c.radius + 1e-6).c_str());
  shape->SetAttribute("length", fmt::format("{:.6g}", length).c_str());
}

// Makes a tree plain, for the way to a link. `fill`: what is missing or cannot be is filled in.
class Plain {
 public:
  Plain(UrdfTree* tree, const fs::path& file, const std::string& end, bool fill)
      : tree_(*tree), file_(file), way_(tree->way_to(end)), fill_(fill) {
    for (UrdfElement* link : tree_.links) ways_.emplace_back(link, tree_.way_to(name_of(link)));
    for (UrdfElement* joint : tree_.joints) fix(joint);
    if (!fixed_.empty())
      notes.push_back("joints that do not carry the tip are fixed where they stand:" + fixed_);
    for (UrdfElement* joint : tree_.joints) keep_first(joint, "joint '" + name_of(joint) + "'");
    for (UrdfElement* link : tree_.links) {
      for (const char* part : {"inertial", "visual", "collision"})
        for (UrdfElement* e : all(link, part))
          keep_first(e, fmt::format("link '{}': its {}", name_of(link), part));
      make_bodies(link);
    }
    if (tree_.text().find("<capsule") != std::string::npos &&
        !tree_.document.RootElement()->Attribute("version", "1.2"))
      tree_.document.RootElement()->SetAttribute("version", "1.1");  // which has capsules
    for (UrdfElement* link : tree_.links) check_inertia(link);
    for (UrdfElement* joint : way_)
      if (!is_type(joint, "fixed")) check_mass(joint);
    for (UrdfElement* joint : way_) {
      if (!is_type(joint, "revolute") && !is_type(joint, "prismatic")) continue;
      check_axis_and_dynamics(joint);
      check_limits(joint);
    }
  }

  std::vector<std::string> notes;

 private:
  // Refuses, or notes what is filled in.
  void fault(const std::string& what, const std::string& valid, const std::string& filled) {
    if (!fill_)
      throw InputError(
          fmt::format("{}; valid is {}; ./impedraw arm make-urdf fills it in", what, valid));
    notes.push_back(fmt::format("{}: {}", what, filled));
  }

  // An element may stand twice where URDF has one: the first counts, as urdfdom has it.
  void keep_first(UrdfElement* e, const std::string& what) {
    for (auto* one = e->FirstChildElement(); one; one = one->NextSiblingElement())
      while (auto* other = one->NextSiblingElement(one->Name())) {
        notes.push_back(fmt::format("{} has another <{}>: the first counts", what, one->Name()));
        e->DeleteChild(other);
      }
  }

  void fix(UrdfElement* joint) {
    auto* limit = joint->FirstChildElement("limit");
    const bool on_way = std::find(way_.begin(), way_.end(), joint) != way_.end();
    if (on_way && is_type(joint, "continuous")) {
      joint->SetAttribute("type", "revolute");
      if (!limit) limit = joint->InsertNewChildElement("limit");
      limit->SetAttribute("lower", -2.0 * M_PI);
      limit->SetAttribute("upper", 2.0 * M_PI);
    } else if (!on_way && !is_type(joint, "fixed")) {
      const double low = number(limit, "lower"), high = number(limit, "upper");
      const double q = low < high ? std::clamp(0.0, low, high) : 0.0;
      Isometry3d X = placement_of(joint);
      if (is_type(joint, "prismatic")) X.translate(q * axis_of(joint));
      if (is_type(joint, "revolute")) X.rotate(Eigen::AngleAxisd(q, axis_of(joint)));
      if (q != 0.0) set_placement(joint, X);
      joint->SetAttribute("type", "fixed");
      fixed_ += " " + name_of(joint);
    }
    if (is_type(joint, "fixed"))
      for (UrdfElement* mimic : all(joint, "mimic")) joint->DeleteChild(mimic);
  }

  // A link as long as the way from the base to the tip has another unit.
  void judge_size(const UrdfElement* link, const std::string& name,
                  const std::vector<Triangle>& triangles) {
    double way = 0.0;
    for (const UrdfElement* joint : way_) way += placement_of(joint).translation().norm();
    Eigen::AlignedBox3d box;
    for (const Triangle& t : triangles)
      for (const Vector3d& p : t) box.extend(p);
    const double size = box.isEmpty() ? 0.0 : box.sizes().maxCoeff();
    if (size > way)
      notes.push_back(
          fmt::format("link '{}': its collision mesh '{}' measures {:.2f} m, the way from the base "
                      "to the tip {:.2f} m: is its scale right?",
                      name_of(link), name, size, way));
  }

  // The capsules of a mesh, in the link's frame.
  std::vector<Capsule> mesh_capsules(const UrdfElement* link, const UrdfElement* mesh,
                                     const Isometry3d& X) {
    const fs::path found = urdf_mesh(file_, value(mesh, "filename"));
    std::string why = "it is neither beside the description nor above it";
    try {
      std::vector<Triangle> triangles;
      if (!found.empty()) triangles = read_triangles(found);
      for (Triangle& t : triangles)
        for (Vector3d& p : t) p = X * Vector3d(p.cwiseProduct(vector(mesh, "scale", 1.0)));
      if (!found.empty()) {
        judge_size(link, value(mesh, "filename"), triangles);
        return enclosing_capsules(triangles);
      }
    } catch (const InputError& error) {
      why = error.what();
    }
    fault(fmt::format("link '{}': its collision mesh '{}' cannot be read: {}", name_of(link),
                      value(mesh, "filename"), why),
          "an STL, Collada or OBJ file",
          fmt::format("a body of {:.0f} mm around the way to the next joint is in its place",
                      1e3 * kBodyRadius));
    std::vector<Capsule> capsules;
    for (const UrdfElement* joint : tree_.joints)
      if (parent_of(joint) == name_of(link))
        capsules.push_back({Vector3d::Zero(), placement_of(joint).translation(), kBodyRadius});
    return capsules;
  }

  void make_bodies(UrdfElement* link) {
    for (UrdfElement* body : all(link, "collision")) {
      auto* geometry = body->FirstChildElement("geometry");
      const auto* shape = geometry ? geometry->FirstChildElement() : nullptr;
      const std::string kind = shape ? shape->Name() : "";
      if (shape && has_no_size(shape)) {
        notes.push_back(fmt::format("link '{}': its collision {} has no size: it is left out",
                                    name_of(link), kind));
        link->DeleteChild(body);
        continue;
      }
      // urdfdom drops a body whose numbers it cannot read, and MuJoCo has words of its own.
      for (const char* what : {"radius", "length"})
        if (double x = 1.0; shape && shape->Attribute(what) &&
                            (shape->QueryDoubleAttribute(what, &x) != tinyxml2::XML_SUCCESS ||
                             !(x > 0.0 && std::isfinite(x))))
          throw InputError(fmt::format("link '{}': a {}'s {} is {} m; valid is more than 0 m",
                                       name_of(link), kind, what, value(shape, what)));
      if (kind != "box" && kind != "mesh") continue;
      const Isometry3d X = placement_of(body);
      std::vector<Capsule> capsules;
      if (kind == "mesh") {
        capsules = mesh_capsules(link, shape, X);
      } else {
        const Vector3d edges = vector(shape, "size", 0.0);
        if (!(edges.minCoeff() >= 0.0))
          throw InputError(
              fmt::format("link '{}': a box's size is \"{}\" m; valid are three edges "
                          "of 0 m or more",
                          name_of(link), value(shape, "size")));
        int i = 0;
        edges.maxCoeff(&i);
        const Vector3d axis = 0.5 * edges[i] * Vector3d::Unit(i);
        const double across = 0.5 * std::sqrt(edges.squaredNorm() - edges[i] * edges[i]);
        capsules = {{X * Vector3d(-axis), X * axis, across}};
      }
      for (const Capsule& c : capsules) add_body(link, c);
      link->DeleteChild(body);
    }
    // Those that are drawn, by their place: the description may move.
    for (UrdfElement* body : all(link, "visual"))
      if (auto* geometry = body->FirstChildElement("geometry"))
        for (UrdfElement* mesh : all(geometry, "mesh"))
          if (const fs::path found = urdf_mesh(file_, value(mesh, "filename")); !found.empty())
            mesh->SetAttribute("filename", found.c_str());
  }

  void check_inertia(UrdfElement* link) {
    const auto* inertial = link->FirstChildElement("inertial");
    // MuJoCo would make one of the bodies.
    if (!inertial && link->FirstChildElement("collision"))
      set_inertial(link, 0.0, Matrix3d::Zero());
    if (mass_of(inertial) < 0.0)
      throw InputError(fmt::format("link '{}': <mass value=\"{}\">; valid is 0 kg or more",
                                   name_of(link), mass_of(inertial)));
    const Matrix3d I = inertia_of(inertial);
    const Eigen::SelfAdjointEigenSolver<Matrix3d> principal(I);
    const Vector3d given = principal.eigenvalues();
    Vector3d moments = given.cwiseMax(0.0);
    const auto lacking = [&moments](double slack) {
      return (1.0 + slack) * moments[2] - moments[0] - moments[1];
    };
    const double lacks = lacking(0.0);
    if (given.isZero(0.0) || (given[0] >= kLeastMoment && lacking(kSlack) <= 0.0)) return;
    moments = moments.cwiseMax(kLeastMoment);
    moments.head(2).array() += 0.5 * std::max(0.0, lacking(kSlack));
    if (std::max(lacks, -given[0]) > kRounding * moments[2])
      fault(fmt::format("link '{}': <inertia ixx=\"{:.6g}\" iyy=\"{:.6g}\" izz=\"{:.6g}\" "
                        "ixy=\"{:.6g}\" ixz=\"{:.6g}\" iyz=\"{:.6g}\"> breaks the triangle rule, "
                        "with principal moments of {:.6g}, {:.6g} and {:.6g} kg m²",
                        name_of(link), I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2),
                        given[0], given[1], given[2]),
            "an inertia whose principal moments are 0 or more, none above the sum of the others",
            fmt::format("they became {:.6g}, {:.6g} and {:.6g} kg m²", moments[0], moments[1],
                        moments[2]));
    const Matrix3d& R = principal.eigenvectors();
    set_inertial(link, mass_of(inertial), R * moments.asDiagonal() * R.transpose());
  }

  // The links that a joint of the way moves, and no joint after it.
  UrdfElements moved_by(const UrdfElement* joint) const {
    const auto fixed = [](const UrdfElement* j) { return is_type(j, "fixed"); };
    UrdfElements moved;
    for (const auto& [link, way] : ways_) {
      const auto at = std::find(way.begin(), way.end(), joint);
      if (at != way.end() && std::all_of(at + 1, way.end(), fixed)) moved.push_back(link);
    }
    return moved;
  }

  void check_mass(const UrdfElement* joint) {
    double mass = 0.0, moment = 0.0;
    const UrdfElements moved = moved_by(joint);
    for (const UrdfElement* link : moved) {
      mass += mass_of(link->FirstChildElement("inertial"));
      moment += inertia_of(link->FirstChildElement("inertial")).trace();
    }
    if ((mass > 0.0 && moment > 0.0) || moved.empty()) return;
    const double filled = mass > 0.0 ? mass_of(moved[0]->FirstChildElement("inertial")) : kMass;
    fault(
        fmt::format("link '{}', which joint '{}' moves, and what is fixed to it have no {}",
                    child_of(joint), name_of(joint), mass > 0.0 ? "<inertia>" : "<mass>"),
        "an <inertial> with a <mass> and an <inertia> above 0",
        fmt::format("it became {} kg in a ball of {:.0f} mm", std::max(filled, mass), 1e3 * kBall));
    set_inertial(tree_.link(child_of(joint)), filled,
                 0.4 * std::max(filled, mass) * kBall * kBall * Matrix3d::Identity());
  }

  void check_axis_and_dynamics(const UrdfElement* joint) const {
    const auto* axis = joint->FirstChildElement("axis");
    if (axis && !(vector(axis, "xyz", 0.0).norm() > kLeastAxis))
      throw InputError(
          fmt::format("joint '{}': <axis xyz=\"{}\">; valid is a direction, as in \"0 0 1\"",
                      name_of(joint), value(axis, "xyz")));
    const auto* dynamics = joint->FirstChildElement("dynamics");
    for (const char* what : {"damping", "friction"})
      if (const double x = number(dynamics, what); !(x >= 0.0 && x <= kMostDynamics))
        throw InputError(fmt::format("joint '{}': <dynamics {}=\"{}\">; valid are 0 to {:g}",
                                     name_of(joint), what, value(dynamics, what), kMostDynamics));
  }

  void check_limits(UrdfElement* joint) {
    const bool slides = is_type(joint, "prismatic");
    auto* limit = joint->FirstChildElement("limit");
    if (!limit)
      throw InputError(fmt::format(
          "joint '{}' has no <limit>; valid is one with lower, upper, effort and velocity",
          name_of(joint)));
    const auto require = [&](const char* what, const char* unit, const auto& otherwise) {
      if (number(limit, what) >= kLeastLimit && std::isfinite(number(limit, what))) return;
      const double filled = otherwise();
      fault(limit->Attribute(what)
                ? fmt::format("joint '{}': <limit {}=\"{}\">", name_of(joint), what,
                              value(limit, what))
                : fmt::format("joint '{}': <limit> without {}", name_of(joint), what),
            fmt::format("{} {} or more", kLeastLimit, unit),
            fmt::format("it became {:.3g} {}", filled, unit));
      limit->SetAttribute(what, filled);
    };
    require("effort", slides ? "N" : "Nm", [&] { return std::ceil(load(joint, slides)); });
    require("velocity", slides ? "m/s" : "rad/s", [&] { return slides ? 0.25 : 1.5; });
  }

  // Twice the weight beyond the joint, stretched out, and a little [Nm], [N].
  double load(const UrdfElement* joint, bool slides) const {
    double carries = slides ? 50.0 : 10.0;
    for (const auto& [link, way] : ways_) {
      auto at = std::find(way.begin(), way.end(), joint);
      if (at == way.end()) continue;
      const auto* inertial = link->FirstChildElement("inertial");
      double reach = inertial ? placement_of(inertial).translation().norm() : 0.0;
      while (++at != way.end()) reach += placement_of(*at).translation().norm();
      carries += 2.0 * 9.81 * mass_of(inertial) * (slides ? 1.0 : reach);
    }
    return carries;
  }

  UrdfTree& tree_;
  fs::path file_;
  UrdfElements way_;
  std::vector<std::pair<UrdfElement*, UrdfElements>> ways_;  // to each link, from the root
  bool fill_;
  std::string fixed_;
};

// The last joint's axis in its link R, away from the arm: from the first of the joints before it
// that does not lie abreast of p_R.
Vector3d outwards(const UrdfElements& way, const Vector3d& p_R) {
  Vector3d axis = Vector3d::UnitZ();
  Isometry3d X_RA = Isometry3d::Identity();
  bool moved = false;
  for (auto joint = way.rbegin(); joint != way.rend(); ++joint) {
    if (!moved && is_type(*joint, "fixed")) continue;
    if (!moved) axis = axis_of(*joint);
    moved = true;
    const double beyond = axis.dot(p_R - X_RA.translation());
    if (std::abs(beyond) > 1e-3) return beyond > 0.0 ? axis : Vector3d(-axis);
    X_RA = X_RA * placement_of(*joint).inverse();
  }
  return axis;
}

// The place where the pen begins, in F.
struct Mount {
  std::string flange;                        // F
  Isometry3d X_FM = Isometry3d::Identity();  // z along the pen
};

std::string listed(const std::vector<std::string>& names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

Mount find_mount(const UrdfTree& tree, const std::string& flange, std::vector<std::string>* notes) {
  const std::vector<ArmEnd> ends = arm_ends(tree);
  std::vector<std::string> candidates = flange_candidates(ends);
  if (ends.size() == 1 && ends[0].chain && candidates.size() > 1)  // nameless: its last link
    candidates = {candidates.back()};
  if (flange.empty() && candidates.size() != 1)
    throw InputError(candidates.empty() ? "it holds no arm of 6 joints or more"
                                        : "which link carries the pen is not clear; --flange takes "
                                          "one of " +
                                              listed(candidates));
  Mount mount{flange.empty() ? candidates[0] : flange};
  for (const ArmEnd& end : ends)
    for (std::size_t i = 0; i < end.links.size(); ++i) {
      if (name_of(end.links[i]) != mount.flange) continue;
      const Vector3d out = end.X_RL[i].linear().transpose() *
                           outwards(tree.way_to(mount.flange), end.X_RL[i].translation());
      if (flange.empty() && out.z() < 0.99) mount.X_FM.rotate(turn_between(Vector3d::UnitZ(), out));
      notes->push_back(fmt::format("the pen stands on '{}', along its ({:.2f}, {:.2f}, {:.2f})",
                                   mount.flange, mount.X_FM(0, 2), mount.X_FM(1, 2),
                                   mount.X_FM(2, 2)));
      if (mount.X_FM.linear().col(2).dot(out) < 0.99)
        notes->push_back(
            fmt::format("the last joint's axis leaves the arm along its ({:.2f}, "
                        "{:.2f}, {:.2f})",
                        out.x(), out.y(), out.z()));
      return mount;
    }
  throw InputError(fmt::format("--flange {}: no such link at an arm's end; candidates are {}",
                               flange, listed(candidates)));
}

// The distance along the pen at which the bodies end that the last joint carries, but for those
// that carry F.
double end_of_bodies(const UrdfTree& tree, const Mount& mount) {
  const UrdfElements way = tree.way_to(mount.flange);
  double reach = 0.0;
  for (const ArmEnd& end : arm_ends(tree))  // now with the gripper, which is fixed
    for (std::size_t f = 0; f < end.links.size(); ++f) {
      if (name_of(end.links[f]) != mount.flange) continue;
      const Isometry3d X_MR = (end.X_RL[f] * mount.X_FM).inverse();
      for (std::size_t i = 0; i < end.links.size(); ++i) {
        const std::string name = name_of(end.links[i]);
        if (std::any_of(way.begin(), way.end(), [&name](auto* j) { return parent_of(j) == name; }))
          continue;
        for (UrdfElement* body : all(end.links[i], "collision")) {
          const auto* geometry = body->FirstChildElement("geometry");
          const auto* shape = geometry ? geometry->FirstChildElement() : nullptr;
          const Isometry3d X_MB = X_MR * end.X_RL[i] * placement_of(body);
          reach = std::max(reach, X_MB(2, 3) + number(shape, "radius") +
                                      0.5 * number(shape, "length") * std::abs(X_MB(2, 2)));
        }
      }
    }
  return reach;
}

template <typename Read>
PlainUrdf named(const fs::path& file, Read read) {
  const std::string where = "arm description " + file.string();
  try {
    return read();
  } catch (const InputError& error) {
    const std::string what = error.what();
    const bool placed = what.starts_with(where) || what.starts_with(file.string());
    throw InputError(placed ? what : where + ": " + what);
  } catch (const std::exception& error) {  // urdfdom's, of a vector
    throw InputError(fmt::format("{}: not a valid URDF: {}", where, error.what()));
  }
}

}  // namespace

PlainUrdf plain_urdf(const fs::path& file, const std::string& tip) {
  return named(file, [&]() -> PlainUrdf {
    UrdfTree tree(file);
    std::string end = tip;
    for (const UrdfElement* joint : tree.joints)  // a joint's frame is that of its link
      if (!tree.link(tip) && name_of(joint) == tip) end = child_of(joint);
    if (!tree.link(end)) {
      const std::vector<std::string> candidates = flange_candidates(arm_ends(tree));
      throw InputError(fmt::format(
          "no frame named '{}'{}", tip,
          candidates.empty()
              ? ""
              : fmt::format("; ./impedraw arm make-urdf --arm {} --flange LINK puts a pen on it; "
                            "candidates for LINK are {}",
                            file.string(), listed(candidates))));
    }
    Plain plain(&tree, file, end, false);
    return {tree.text(), plain.notes};
  });
}

PlainUrdf vendor_urdf_with_pen(const fs::path& file, const std::string& flange,
                               const PenOnFlange& pen) {
  return named(file, [&]() -> PlainUrdf {
    UrdfTree tree(file);
    if (tree.link("tip")) {
      const Plain plain(&tree, file, "tip", true);
      std::vector<std::string> notes{"it has a link 'tip': no pen was added"};
      notes.insert(notes.end(), plain.notes.begin(), plain.notes.end());
      return {tree.text(), notes};
    }
    std::vector<std::string> notes;
    Mount mount = find_mount(tree, flange, &notes);
    const Plain plain(&tree, file, mount.flange, true);
    const double reach = end_of_bodies(tree, mount);
    if (reach > 0.0)
      notes.push_back(fmt::format(
          "the last joint carries bodies up to {:.0f} mm along the pen, which begins there",
          1e3 * reach));
    notes.insert(notes.end(), plain.notes.begin(), plain.notes.end());
    std::string on = mount.flange;
    if (on != "flange" || reach > 0.0 || !mount.X_FM.isApprox(Isometry3d::Identity())) {
      on = tree.link("flange") ? "pen_mount" : "flange";
      fix_link(&tree, mount.flange, mount.X_FM.translate(reach * Vector3d::UnitZ()), on);
    }
    return {urdf_with_pen(tree.text(), pen, on), notes};
  });
}

fs::path urdf_mesh(const fs::path& urdf, const std::string& name) {
  const std::size_t scheme = name.find("://");
  const std::string path = scheme == name.npos ? name : name.substr(scheme + 3);
  const std::string in_package = scheme == name.npos ? "" : path.substr(path.find('/') + 1);
  std::error_code error;
  fs::path folder = fs::absolute(urdf, error).parent_path();
  for (int up = 0; up < 12; ++up, folder = folder.parent_path())
    for (const std::string& n : {path, in_package})
      if (!n.empty() && fs::is_regular_file(folder / n, error)) return folder / n;
  return {};
}

}  // namespace impedraw
