// Values of an arm's joints, which a setting gives once for all or one by one.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "impedraw/common/errors.h"

namespace impedraw {

// One entry per joint: zeros for none, the same for one. Throws InputError for any other number.
inline Eigen::VectorXd per_joint(const std::string& name, const std::vector<double>& values,
                                 int joints) {
  const auto size = static_cast<Eigen::Index>(values.size());
  if (size <= 1) return Eigen::VectorXd::Constant(joints, size == 1 ? values[0] : 0.0);
  if (size != joints)
    throw InputError(name + " has " + std::to_string(size) + " entries, but the arm has " +
                     std::to_string(joints) + " joints; valid are one entry for all joints, " +
                     std::to_string(joints) + " entries, or none");
  return Eigen::Map<const Eigen::VectorXd>(values.data(), size);
}

}  // namespace impedraw
