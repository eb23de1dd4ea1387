#include "impedraw/arm/urdf_inertia.h"

namespace impedraw {
namespace {

const char* const kMoments[3][3] = {
    {"ixx", "ixy", "ixz"}, {"ixy", "iyy", "iyz"}, {"ixz", "iyz", "izz"}};

}  // namespace

Eigen::Matrix3d inertia_of(const UrdfElement* inertial) {
  Eigen::Matrix3d I = Eigen::Matrix3d::Zero();
  for (int i = 0; inertial && i < 9; ++i)
    I(i) = number(inertial->FirstChildElement("inertia"), kMoments[i / 3][i % 3]);
  return I;
}

double mass_of(const UrdfElement* inertial) {
  return inertial ? number(inertial->FirstChildElement("mass"), "value") : 0.0;
}

void set_inertial(UrdfElement* link, double mass, const Eigen::Matrix3d& I) {
  auto* inertial = link->FirstChildElement("inertial");
  if (!inertial) inertial = link->InsertNewChildElement("inertial");
  for (const char* part : {"mass", "inertia"})
    if (!inertial->FirstChildElement(part)) inertial->InsertNewChildElement(part);
  inertial->FirstChildElement("mass")->SetAttribute("value", mass);
  for (int i = 0; i < 9; ++i)
    inertial->FirstChildElement("inertia")->SetAttribute(kMoments[i / 3][i % 3], I(i));
}

}  // namespace impedraw
