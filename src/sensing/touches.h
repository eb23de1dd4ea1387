// The length of the pen and the pose of the page, by touching known points.
#pragma once

#include <vector>

#include "impedraw/common/pose.h"

namespace impedraw {

struct PenLength {
  double longer = 0.0;                            // of the true pen than the modelled one [m]
  double error = 0.0;                             // standard error, from the residuals [m]
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  // the point that was touched [m]
  double residual = 0.0;                          // RMS per axis [m]
};

// From the model's tip pose X_WE of touches of one point at several tilts.
//
// Law       p_WE + d z_E = c        z_E: the pen's axis, out of the tip; d, c unknown
// Linear least squares. Throws InputError for fewer than 3 touches, tilts within 10 degrees of each
// other, residuals above 1 mm, or a pen that would be more than 50 mm off.
PenLength identify_pen_length(const std::vector<Pose>& touches);

struct Registration {
  Pose X_WP;              // of the page in the world
  double residual = 0.0;  // RMS distance of a point [m]
};

// The rigid motion that takes marks of the page, p_P, nearest to where they were touched, p_W
// (Kabsch, Acta Cryst. A32, 1976). Throws InputError for fewer than 3 points, different counts,
// marks on one line (within 10 mm), or residuals above 2 mm.
Registration register_page(const std::vector<Eigen::Vector3d>& p_P,
                           const std::vector<Eigen::Vector3d>& p_W);

}  // namespace impedraw
