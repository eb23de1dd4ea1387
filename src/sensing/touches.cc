#include "impedraw/sensing/touches.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <Eigen/SVD>

#include "impedraw/common/errors.h"

namespace impedraw {

namespace {

constexpr double kLeastTilt = 10.0;     // [deg]
constexpr double kPenResidual = 1e-3;   // [m]
constexpr double kMostLonger = 0.05;    // [m]
constexpr double kLeastWidth = 0.01;    // of the marks, across their longest direction [m]
constexpr double kPageResidual = 2e-3;  // [m]

}  // namespace

PenLength identify_pen_length(const std::vector<Pose>& touches) {
  const auto n = static_cast<double>(touches.size());
  if (touches.size() < 3)
    throw InputError(fmt::format("{} touches of the point; at least 3 are needed", touches.size()));
  double tilt = 0.0;
  Eigen::Vector3d z = Eigen::Vector3d::Zero(), p = Eigen::Vector3d::Zero();
  for (const Pose& a : touches) {
    if (!a.p.allFinite() || !a.R.allFinite()) throw InputError("a touch's pose is not finite");
    z += a.R.col(2) / n;
    p += a.p / n;
    for (const Pose& b : touches)
      tilt = std::max(tilt, std::acos(std::clamp(a.R.col(2).dot(b.R.col(2)), -1.0, 1.0)));
  }
  tilt *= 180.0 / std::numbers::pi;
  if (tilt < kLeastTilt)
    throw InputError(fmt::format(
        "the pen's axes are within {:.1f} degrees of each other; at least {:.0f} are needed", tilt,
        kLeastTilt));
  // With the means taken off, c drops out.
  double zz = 0.0, zp = 0.0;
  for (const Pose& a : touches) {
    zz += (a.R.col(2) - z).squaredNorm();
    zp += (a.R.col(2) - z).dot(a.p - p);
  }
  PenLength found;
  found.longer = -zp / zz;
  found.p_W = p + found.longer * z;
  double squares = 0.0;
  for (const Pose& a : touches)
    squares += (a.p + found.longer * a.R.col(2) - found.p_W).squaredNorm();
  found.residual = std::sqrt(squares / (3.0 * n - 4.0));
  found.error = found.residual / std::sqrt(zz);
  if (found.residual > kPenResidual)
    throw InputError(fmt::format(
        "the touches are {:.2f} mm RMS off one point, more than {:.1f} mm: not one point, or the "
        "arm's model is wrong",
        1e3 * found.residual, 1e3 * kPenResidual));
  if (std::abs(found.longer) > kMostLonger)
    throw InputError(fmt::format(
        "the pen would be {:.1f} mm longer than modelled, more than {:.0f} mm: another tool",
        1e3 * found.longer, 1e3 * kMostLonger));
  return found;
}

Registration register_page(const std::vector<Eigen::Vector3d>& p_P,
                           const std::vector<Eigen::Vector3d>& p_W) {
  if (p_P.size() != p_W.size())
    throw InputError(fmt::format("{} marks of the page, and {} touches", p_P.size(), p_W.size()));
  if (p_P.size() < 3)
    throw InputError(fmt::format("{} marks of the page; at least 3 are needed", p_P.size()));
  const auto n = static_cast<double>(p_P.size());
  Eigen::Vector3d mean_P = Eigen::Vector3d::Zero(), mean_W = mean_P;
  for (std::size_t i = 0; i < p_P.size(); ++i) {
    if (!p_P[i].allFinite() || !p_W[i].allFinite())
      throw InputError(fmt::format("mark {}: a coordinate is not finite", i + 1));
    mean_P += p_P[i] / n;
    mean_W += p_W[i] / n;
  }
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero(), cross = spread;
  for (std::size_t i = 0; i < p_P.size(); ++i) {
    spread += (p_P[i] - mean_P) * (p_P[i] - mean_P).transpose() / n;
    cross += (p_W[i] - mean_W) * (p_P[i] - mean_P).transpose();
  }
  const double width = std::sqrt(Eigen::JacobiSVD<Eigen::Matrix3d>(spread).singularValues()[1]);
  if (!(width >= kLeastWidth))
    throw InputError(
        fmt::format("the marks lie within {:.1f} mm of one line; at least {:.0f} mm are needed",
                    1e3 * width, 1e3 * kLeastWidth));
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign = Eigen::Vector3d::Ones();
  sign[2] = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  Registration found;
  found.X_WP.R = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  found.X_WP.p = mean_W - found.X_WP.R * mean_P;
  double squares = 0.0;
  for (std::size_t i = 0; i < p_P.size(); ++i)
    squares += (found.X_WP * p_P[i] - p_W[i]).squaredNorm();
  found.residual = std::sqrt(squares / n);
  if (found.residual > kPageResidual)
    throw InputError(fmt::format(
        "the touches are {:.2f} mm RMS off the marks, more than {:.1f} mm: a mark was mistaken, or "
        "the pen's length is wrong",
        1e3 * found.residual, 1e3 * kPageResidual));
  return found;
}

}  // namespace impedraw
