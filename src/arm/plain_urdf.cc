#include "impedraw/arm/plain_urdf.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

#include "impedraw/arm/enclosing_capsules.h"
#include "impedraw/arm/urdf_flange.h"
#include "impedraw/arm/urdf_tree.h"
#include "impedraw/common/errors.h"

namespace impedraw {

namespace {

using Eigen::Vector3d;
namespace fs = std::filesystem;

constexpr double kTurn = 2.0 * std::numbers::pi;  // range of a continuous joint [rad]
constexpr double kBodyRadius = 0.06;              // in place of a mesh [m]
constexpr double kDensity = 1000.0;               // [kg/m³]
constexpr double kMass = 0.5, kBall = 0.05;       // of a link without a body [kg], [m]
constexpr double kRounding = 1e-3;  // of the largest moment: digits that a file left out
const char* const kMomentNames[] = {"ixx", "ixy", "ixz", "ixy", "iyy", "iyz", "ixz", "iyz", "izz"};

// Makes a tree plain, for a way to a link. `fill`: what is missing or cannot be is filled in.
class Plain {
 public:
  Plain(UrdfTree* tree, const fs::path& file, const std::string& end, bool fill)
      : tree_(*tree), file_(file), way_(tree->way_to(end)), fill_(fill) {
    fix_joints();
    for (UrdfElement* link : tree_.links) make_bodies(link), name_meshes(link);
    if (tree_.text().find("<capsule") != std::string::npos &&
        !tree_.robot->Attribute("version", "1.2"))
      tree_.robot->SetAttribute("version", "1.1");  // capsules are new in it
    for (UrdfElement* link : tree_.links) check_inertia(link);
    for (UrdfElement* joint : way_) check_mass(joint);
    for (UrdfElement* joint : way_) check_limits(joint);
  }

  std::vector<std::string> notes;

 private:
  bool on_the_way(const UrdfElement* joint) const {
    return std::find(way_.begin(), way_.end(), joint) != way_.end();
  }

  // Refuses, or notes what is filled in.
  void fault(const std::string& what, const std::string& valid, const std::string& filled) {
    if (!fill_)
      throw InputError(
          fmt::format("{}; valid {}; ./impedraw arm make-urdf fills it in", what, valid));
    notes.push_back(fmt::format("{}: {}", what, filled));
  }

  double standing(const UrdfElement* joint, int depth = 0) const {
    double q = 0.0;
    if (const auto* mimic = joint->FirstChildElement("mimic"); mimic && depth < 8) {
      for (const UrdfElement* master : tree_.joints)
        if (mimic->Attribute("joint", name_of(master).c_str())) q = standing(master, depth + 1);
      q = number_of(mimic, "offset", 0.0) + q * number_of(mimic, "multiplier", 1.0);
    }
    const auto* limit = joint->FirstChildElement("limit");
    const double low = number_of(limit, "lower", 0.0), high = number_of(limit, "upper", 0.0);
    return low < high && type_of(joint) != "continuous" ? std::clamp(q, low, high) : q;
  }

  void fix_joints() {
    std::string fixed;
    for (UrdfElement* joint : tree_.joints) {
      const std::string type = type_of(joint);
      if (on_the_way(joint)) {
        if (type != "continuous") continue;
        joint->SetAttribute("type", "revolute");
        auto* limit = joint->FirstChildElement("limit");
        if (!limit) limit = joint->InsertNewChildElement("limit");
        limit->SetAttribute("lower", -kTurn);
        limit->SetAttribute("upper", kTurn);
      } else if (type != "fixed") {
        const double q = standing(joint);
        const Vector3d axis = joint->FirstChildElement("axis")
                                  ? vector_of(joint->FirstChildElement("axis"), "xyz")
                                  : Vector3d::UnitX();
        Eigen::Isometry3d X = placement_of(joint);
        if (q != 0.0 && type == "prismatic") X.translate(q * axis.normalized());
        if (q != 0.0 && type != "prismatic") X.rotate(Eigen::AngleAxisd(q, axis.normalized()));
        if (q != 0.0) set_placement(joint, X);
        joint->SetAttribute("type", "fixed");
        if (auto* mimic = joint->FirstChildElement("mimic")) joint->DeleteChild(mimic);
        fixed += (fixed.empty() ? "" : ", ") + name_of(joint);
      }
    }
    if (!fixed.empty())
      notes.push_back("joints that do not carry the tip are fixed where they stand: " + fixed);
  }

  std::vector<Capsule> stand_in(const std::string& link) const {
    std::vector<Capsule> capsules;
    for (const UrdfElement* joint : tree_.joints)
      if (parent_of(joint) == link)
        capsules.push_back({Vector3d::Zero(), placement_of(joint).translation(), kBodyRadius});
    if (capsules.empty()) capsules.push_back({Vector3d::Zero(), Vector3d::Zero(), kBodyRadius});
    return capsules;
  }

  // Of a box or a mesh, in the link's frame.
  std::vector<Capsule> capsules_of(const UrdfElement* body, const std::string& link) {
    const auto* geometry = body->FirstChildElement("geometry");
    const auto *box = geometry->FirstChildElement("box"),
               *mesh = geometry->FirstChildElement("mesh");
    std::vector<Triangle> triangles;
    if (box) {
      const Vector3d edges = vector_of(box, "size");
      if (!(edges.minCoeff() > 0.0))
        throw InputError(
            fmt::format("link '{}': a box's size is {} {} {} m; valid is more than 0 m", link,
                        edges.x(), edges.y(), edges.z()));
      triangles = box_triangles(edges);
    } else {
      const std::string name = mesh->Attribute("filename") ? mesh->Attribute("filename") : "";
      std::string why;
      try {
        const fs::path found = urdf_mesh(file_, name);
        if (found.empty()) throw InputError("found neither beside the description nor above it");
        triangles = read_triangles(found);
      } catch (const InputError& error) {
        why = error.what();
      }
      if (!why.empty()) {
        fault(
            fmt::format("link '{}': its collision mesh '{}' cannot be read ({})", link, name, why),
            "is an STL, Collada or OBJ file",
            fmt::format("in its place are capsules of {:.0f} mm to the next joints",
                        1e3 * kBodyRadius));
        return stand_in(link);
      }
      const Vector3d scale = vector_of(mesh, "scale", 1.0);
      for (Triangle& t : triangles)
        for (Vector3d& p : t) p = p.cwiseProduct(scale).eval();
    }
    const Eigen::Isometry3d X = placement_of(body);
    for (Triangle& t : triangles)
      for (Vector3d& p : t) p = X * p;
    return enclosing_capsules(triangles);
  }

  void make_bodies(UrdfElement* link) {
    std::vector<UrdfElement*> foreign;
    for (auto* e = link->FirstChildElement("collision"); e; e = e->NextSiblingElement("collision"))
      if (const auto* g = e->FirstChildElement("geometry");
          g && (g->FirstChildElement("box") || g->FirstChildElement("mesh")))
        foreign.push_back(e);
    for (UrdfElement* body : foreign) {
      for (const Capsule& c : capsules_of(body, name_of(link))) {
        const double length = (c.b - c.a).norm();
        auto* collision = link->InsertNewChildElement("collision");
        Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
        X.translate(0.5 * (c.a + c.b));
        if (length > 1e-4) X.rotate(z_along(c.b - c.a));
        set_placement(collision, X);
        auto* shape = collision->InsertNewChildElement("geometry")
                          ->InsertNewChildElement(length > 1e-4 ? "capsule" : "sphere");
        shape->SetAttribute("radius", fmt::format("{:.6g}", c.radius + 0.5e-4).c_str());
        if (length > 1e-4) shape->SetAttribute("length", fmt::format("{:.6g}", length).c_str());
      }
      link->DeleteChild(body);
    }
  }

  // Those that are drawn, by their place: the description may move.
  void name_meshes(UrdfElement* link) const {
    for (auto* e = link->FirstChildElement("visual"); e; e = e->NextSiblingElement("visual"))
      if (auto* g = e->FirstChildElement("geometry"))
        if (auto* mesh = g->FirstChildElement("mesh"); mesh && mesh->Attribute("filename"))
          if (const fs::path found = urdf_mesh(file_, mesh->Attribute("filename")); !found.empty())
            mesh->SetAttribute("filename", found.c_str());
  }

  double mass_of(const UrdfElement* link) const {
    const auto* inertial = link->FirstChildElement("inertial");
    return inertial ? number_of(inertial->FirstChildElement("mass"), "value", 0.0) : 0.0;
  }

  Eigen::Matrix3d inertia_of(const UrdfElement* link) const {
    const auto* inertial = link->FirstChildElement("inertial");
    Eigen::Matrix3d I;
    for (int i = 0; i < 9; ++i)
      I(i) = inertial ? number_of(inertial->FirstChildElement("inertia"), kMomentNames[i], 0.0) : 0;
    return I;
  }

  void set_inertial(UrdfElement* link, double mass, const Eigen::Matrix3d& I) {
    auto* inertial = link->FirstChildElement("inertial");
    if (!inertial) inertial = link->InsertNewChildElement("inertial");
    for (const char* part : {"mass", "inertia"})
      if (!inertial->FirstChildElement(part)) inertial->InsertNewChildElement(part);
    inertial->FirstChildElement("mass")->SetAttribute("value", fmt::format("{:.6g}", mass).c_str());
    for (int i = 0; i < 9; ++i)
      inertial->FirstChildElement("inertia")->SetAttribute(kMomentNames[i],
                                                           fmt::format("{:.9g}", I(i)).c_str());
  }

  void check_inertia(UrdfElement* link) {
    const std::string name = name_of(link);
    // MuJoCo would make one of the bodies.
    if (!link->FirstChildElement("inertial") && link->FirstChildElement("collision"))
      set_inertial(link, 0.0, Eigen::Matrix3d::Zero());
    const double mass = mass_of(link);
    if (mass < 0.0)
      throw InputError(
          fmt::format("link '{}': <mass value=\"{}\">; valid is 0 kg or more", name, mass));
    const Eigen::Matrix3d I = inertia_of(link);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(I);
    Vector3d moments = principal.eigenvalues();
    const double lacks = moments[2] - moments[0] - moments[1];
    if (lacks <= 0.0 && moments[0] >= 0.0) return;
    const Vector3d given = moments;
    moments = moments.cwiseMax(0.0);
    moments.head(2).array() +=
        0.5 * (1.0 + 1e-6) * std::max(0.0, moments[2] - moments[0] - moments[1]);
    if (std::max(lacks, -given[0]) > kRounding * given.cwiseAbs().maxCoeff())
      fault(fmt::format("link '{}': <inertia ixx=\"{:.6g}\" iyy=\"{:.6g}\" izz=\"{:.6g}\" "
                        "ixy=\"{:.6g}\" ixz=\"{:.6g}\" iyz=\"{:.6g}\"> breaks the triangle rule: "
                        "its principal moments are {:.6g}, {:.6g} and {:.6g} kg m²",
                        name, I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2), given[0],
                        given[1], given[2]),
            "are moments of 0 or more of which none exceeds the sum of the other two",
            fmt::format("they became {:.6g}, {:.6g} and {:.6g} kg m²", moments[0], moments[1],
                        moments[2]));
    set_inertial(
        link, mass,
        principal.eigenvectors() * moments.asDiagonal() * principal.eigenvectors().transpose());
  }

  // Every joint of the way moves a mass: of its link and what is fixed to that.
  void check_mass(UrdfElement* joint) {
    const std::string name = child_of(joint);
    double mass = 0.0, moment = 0.0;
    for (const UrdfElement* link : tree_.links) {
      const std::vector<UrdfElement*> way = tree_.way_to(name_of(link));
      const auto last = std::find_if(way.rbegin(), way.rend(),
                                     [this](UrdfElement* j) { return type_of(j) != "fixed"; });
      if (last == way.rend() || *last != joint) continue;
      mass += mass_of(link);
      moment += inertia_of(link).trace();
    }
    if ((mass > 0.0 && moment > 0.0) || !tree_.link.contains(name) || type_of(joint) == "fixed")
      return;
    UrdfElement* link = tree_.link[name];
    if (!(mass > 0.0)) {
      double volume = 0.0;
      for (auto* e = link->FirstChildElement("collision"); e;
           e = e->NextSiblingElement("collision"))
        if (const auto* g = e->FirstChildElement("geometry"); g && g->FirstChildElement()) {
          const auto* shape = g->FirstChildElement();
          const double r = number_of(shape, "radius", 0.0), l = number_of(shape, "length", 0.0);
          volume += std::numbers::pi * r * r *
                    (l + (std::string(shape->Name()) == "cylinder" ? 0.0 : 4.0 / 3.0 * r));
        }
      mass = volume > 0.0 ? kDensity * volume : kMass;
      fault(fmt::format("link '{}', which joint '{}' moves, has no mass, and neither has what is "
                        "fixed to it",
                        name, name_of(joint)),
            "is an <inertial> with a <mass> above 0 kg", fmt::format("it became {:.3g} kg", mass));
    } else {
      fault(fmt::format("link '{}', which joint '{}' moves, has no inertia, and neither has what "
                        "is fixed to it",
                        name, name_of(joint)),
            "is an <inertial> with an <inertia> above 0 kg m²",
            fmt::format("it became that of a ball of {:.0f} mm", 1e3 * kBall));
      mass = mass_of(link);
    }
    set_inertial(link, mass,
                 0.4 * std::max(mass, 0.1) * kBall * kBall * Eigen::Matrix3d::Identity());
  }

  // Twice what carries the arm beyond a joint, stretched out, and a little [Nm], [N].
  double carrying(const UrdfElement* joint) const {
    double load = 0.0;
    const bool slides = type_of(joint) == "prismatic";
    for (const UrdfElement* link : tree_.links) {
      const std::vector<UrdfElement*> way = tree_.way_to(name_of(link));
      auto at = std::find(way.begin(), way.end(), joint);
      if (at == way.end()) continue;
      const auto* inertial = link->FirstChildElement("inertial");
      double reach = inertial ? placement_of(inertial).translation().norm() : 0.0;
      while (++at != way.end()) reach += placement_of(*at).translation().norm();
      load += 9.81 * mass_of(link) * (slides ? 1.0 : reach);
    }
    return std::ceil(2.0 * load) + (slides ? 50.0 : 10.0);
  }

  void check_limits(UrdfElement* joint) {
    const std::string type = type_of(joint);
    if (type != "revolute" && type != "prismatic") return;
    const bool slides = type == "prismatic";
    auto* limit = joint->FirstChildElement("limit");
    if (!limit)
      throw InputError(
          fmt::format("joint '{}' has no <limit>; valid is one with lower, upper, "
                      "effort and velocity",
                      name_of(joint)));
    const auto require = [&](const char* what, const char* unit, double otherwise) {
      if (number_of(limit, what, 0.0) > 0.0) return;
      const char* given = limit->Attribute(what);
      fault(given ? fmt::format("joint '{}': <limit {}=\"{}\">", name_of(joint), what, given)
                  : fmt::format("joint '{}': <limit> without {}", name_of(joint), what),
            fmt::format("is more than 0 {}", unit),
            fmt::format("it became {:.3g} {}", otherwise, unit));
      limit->SetAttribute(what, otherwise);
    };
    require("effort", slides ? "N" : "Nm", carrying(joint));
    require("velocity", slides ? "m/s" : "rad/s", slides ? 0.25 : 1.5);
  }

  UrdfTree& tree_;
  fs::path file_;
  std::vector<UrdfElement*> way_;
  bool fill_;
};

template <typename Read>
PlainUrdf named(const fs::path& file, Read read) {
  try {
    return read();
  } catch (const InputError& error) {
    const std::string what = error.what(),
                      where = fmt::format("arm description {}: ", file.string());
    throw InputError(what.starts_with("arm description") || what.starts_with(file.string())
                         ? what
                         : where + what);
  }
}

}  // namespace

PlainUrdf plain_urdf(const fs::path& file, const std::string& tip) {
  return named(file, [&]() -> PlainUrdf {
    UrdfTree tree(file);
    std::string end = tip;
    for (const UrdfElement* joint : tree.joints)  // a joint's frame is that of its link
      if (!tree.link.contains(tip) && name_of(joint) == tip) end = child_of(joint);
    if (!tree.link.contains(end)) {
      const std::vector<std::string> candidates = flange_candidates(tree);
      throw InputError(fmt::format(
          "no frame named '{}'; ./impedraw arm make-urdf --arm {}{} puts a pen on a flange{}", tip,
          file.string(), candidates.empty() ? "" : " --flange LINK",
          candidates.empty() ? ""
                             : fmt::format("; candidates are {}", fmt::join(candidates, ", "))));
    }
    Plain plain(&tree, file, end, false);
    return {tree.text(), plain.notes};
  });
}

PlainUrdf vendor_urdf_with_pen(const fs::path& file, const std::string& flange,
                               const PenOnFlange& pen) {
  return named(file, [&]() -> PlainUrdf {
    UrdfTree tree(file);
    if (tree.link.contains("tip")) {
      Plain plain(&tree, file, "tip", true);
      plain.notes.insert(plain.notes.begin(), "it has a link 'tip': no pen was added");
      return {tree.text(), plain.notes};
    }
    PenMount mount = find_mount(tree, flange);
    Plain plain(&tree, file, mount.link, true);
    const std::string on = put_mount(&tree, &mount);
    plain.notes.insert(plain.notes.begin(), mount.notes.begin(), mount.notes.end());
    return {urdf_with_pen(tree.text(), pen, on), plain.notes};
  });
}

fs::path urdf_mesh(const fs::path& urdf, const std::string& name) {
  const std::size_t scheme = name.find("://");
  const std::string path = scheme == name.npos ? name : name.substr(scheme + 3);
  std::vector<std::string> names{path};
  if (scheme != name.npos && path.find('/') != path.npos)
    names.push_back(path.substr(path.find('/') + 1));
  std::error_code error;
  fs::path folder = fs::absolute(urdf, error).parent_path();
  for (int up = 0; up < 12; ++up, folder = folder.parent_path())
    for (const std::string& n : names)
      if (!n.empty() && fs::is_regular_file(folder / n, error)) return folder / n;
  return {};
}

}  // namespace impedraw
