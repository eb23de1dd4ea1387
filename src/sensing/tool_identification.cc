#include "impedraw/sensing/tool_identification.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <Eigen/SVD>

#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

struct LeastSquares {
  Eigen::VectorXd x, unit_error;  // solution and its standard error for unit residuals
  double residual;                // √(Σ r²/(rows − columns))
  double condition;
  Eigen::VectorXd weakest;  // unit direction of x that A determines worst
};

LeastSquares solve(const Eigen::MatrixXd& A, const Eigen::VectorXd& y) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(A, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const Eigen::VectorXd s = svd.singularValues();
  LeastSquares out;
  out.x = svd.solve(y);
  out.residual =
      std::sqrt((y - A * out.x).squaredNorm() / static_cast<double>(A.rows() - A.cols()));
  out.condition = s[0] / std::max(s[s.size() - 1], 1e-12 * s[0]);
  out.weakest = svd.matrixV().rightCols<1>();
  out.unit_error =
      (svd.matrixV() * s.cwiseMax(1e-12 * s[0]).cwiseInverse().asDiagonal()).rowwise().norm();
  return out;
}

void check(const std::vector<StaticReading>& poses, const Eigen::Vector3d& gravity_W) {
  char message[160];
  if (poses.size() < 3) {
    std::snprintf(message, sizeof message,
                  "tool identification: %zu poses, needs at least 3 of different tilt",
                  poses.size());
    throw InputError(message);
  }
  if (!gravity_W.allFinite() || gravity_W.norm() == 0.0)
    throw InputError("tool identification: gravity_W must be finite and not zero");
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const bool rotation = poses[k].R_WS.allFinite() && poses[k].R_WS.isUnitary(1e-6) &&
                          poses[k].R_WS.determinant() > 0.0;
    if (rotation && poses[k].reading_S.allFinite()) continue;
    std::snprintf(message, sizeof message, "tool identification: pose %zu must have a %s", k,
                  rotation ? "finite reading" : "rotation R_WS");
    throw InputError(message);
  }
}

}  // namespace

ToolIdentification identify_tool(const std::vector<StaticReading>& poses,
                                 const Eigen::Vector3d& gravity_W) {
  check(poses, gravity_W);
  const Eigen::Index rows = 3 * static_cast<Eigen::Index>(poses.size());
  const double g = gravity_W.norm();
  // Unknowns (m g, b_f) and (g h, b_m): columns of equal scale make the condition number
  // meaningful.
  Eigen::MatrixXd A_force(rows, 4), A_torque(rows, 6);
  Eigen::VectorXd f(rows), m(rows);
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const Eigen::Index row = 3 * static_cast<Eigen::Index>(k);
    const Eigen::Vector3d down = poses[k].R_WS.transpose() * gravity_W / g;
    Eigen::Matrix3d cross_down;  // h × down = cross_down h
    cross_down << 0.0, down.z(), -down.y(), -down.z(), 0.0, down.x(), down.y(), -down.x(), 0.0;
    A_force.middleRows<3>(row) << down, Eigen::Matrix3d::Identity();
    A_torque.middleRows<3>(row) << cross_down, Eigen::Matrix3d::Identity();
    f.segment<3>(row) = poses[k].reading_S.head<3>();
    m.segment<3>(row) = poses[k].reading_S.tail<3>();
  }
  const LeastSquares force = solve(A_force, f), torque = solve(A_torque, m);

  char message[320];
  if (force.condition > kMaxCondition) {
    std::snprintf(message, sizeof message,
                  "tool identification: gravity hardly turns in the sensor, mass and force bias "
                  "cannot be told apart (condition %.3g, at most "
                  "%g): tilt the tool further; a turn about the vertical does nothing",
                  force.condition, kMaxCondition);
    throw InputError(message);
  }
  if (torque.condition > kMaxCondition) {
    const Eigen::Vector3d open = torque.weakest.head<3>().normalized();
    std::snprintf(
        message, sizeof message,
        "tool identification: the centre of mass along (%.2f, %.2f, %.2f) of the sensor and the "
        "torque bias cannot be told apart "
        "(condition %.3g, at most %g): add poses that move gravity in the sensor across it",
        open.x(), open.y(), open.z(), torque.condition, kMaxCondition);
    throw InputError(message);
  }

  ToolIdentification out;
  out.mass = force.x[0] / g;
  if (!(out.mass > 0.0)) {
    std::snprintf(
        message, sizeof message,
        "tool identification: the mass comes out at %.3g kg, must be greater than 0: readings "
        "must be the wrench on the tool, weight down",
        out.mass);
    throw InputError(message);
  }
  out.p_SC = torque.x.head<3>() / (g * out.mass);
  out.bias_S << force.x.tail<3>(), torque.x.tail<3>();
  out.residual_force = force.residual;
  out.residual_torque = torque.residual;
  out.mass_error = force.residual * force.unit_error[0] / g;
  const Eigen::Vector3d h_error = torque.residual * torque.unit_error.head<3>() / g;
  out.p_SC_error =
      (h_error.cwiseAbs2() + (out.mass_error * out.p_SC).cwiseAbs2()).cwiseSqrt() / out.mass;
  out.condition = std::max(force.condition, torque.condition);
  return out;
}

}  // namespace impedraw
