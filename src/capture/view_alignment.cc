#include "impedraw/capture/view_alignment.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "impedraw/common/errors.h"
#include "impedraw/common/rotations.h"
#include "impedraw/perception/neighbours.h"

namespace impedraw {

namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kAlignments = 40, kPerReach = 4;
constexpr double kAligned = 1e-7;     // step at which it ends [m]
constexpr double kBelieved = 1.15;    // in the views' agreement, by which a correction is believed
constexpr double kFacing = 0.7;       // cosine between two normals of one surface
constexpr double kQueries = 30000.0;  // in one iteration
constexpr double kRadians = std::numbers::pi / 180.0;
constexpr double kMostShift = 0.010, kMostTurn = 2.0;      // of a camera [m], [deg]
constexpr double kLikelyShift = 0.005, kLikelyTurn = 1.0;  // s [m] and γ [deg]
constexpr double kFirstReach = 0.06, kLastReach = 0.01;    // of a match [m]
constexpr double kLeastOverlap = 0.05;                     // share of a view's samples

struct Match {
  std::size_t a, b;    // views
  Vector6 J;           // of the distance by a motion of view b, turns in units of 1/radius
  double r, variance;  // distance [m]; of it, by the samples [m²]
};

// All views, with turns about c; those of ξ are in units of 1/radius.
class Aligning {
 public:
  explicit Aligning(std::span<const ViewSamples> views)
      : views_(views), T_(views.size()), points_(views.size()) {
    double n = 0.0;
    for (std::size_t v = 0; v < views.size(); ++v)
      for (const SeenPoint& s : views[v].samples) {
        points_[v].push_back(s.p);
        c_ += s.p;
        ++n;
      }
    if (n > 0.0) c_ /= n;
    for (const auto& points : points_)
      for (const Vector3d& p : points) radius_ += (p - c_).squaredNorm();
    radius_ = std::max(1e-3, std::sqrt(radius_ / std::max(n, 1.0)));
    for (const auto& points : points_) trees_.emplace_back(points);
    const double pairs = static_cast<double>(views.size() * (views.size() - 1));
    queries_ = static_cast<std::size_t>(std::clamp(kQueries / std::max(pairs, 1.0), 100.0, 3000.0));
  }

  ViewAlignment run() {
    ViewAlignment result;
    result.rms_before = rms(match(kFirstReach));
    const double as_calibrated = typical(match(kLastReach));
    std::vector<Match> matches;
    double reach = kFirstReach;
    for (int i = 0; i < kAlignments; ++i) {
      if (i > 0 && i % kPerReach == 0) reach = std::max(kLastReach, 0.5 * reach);
      matches = match(reach);
      if (step(matches) < kAligned && reach == kLastReach) break;
    }
    matches = match(kLastReach);
    step(matches);
    if (as_calibrated < kBelieved * typical(matches)) {
      T_.assign(views_.size(), Pose());
      matches = match(kLastReach);
    }
    for (std::size_t v = 0; v < views_.size(); ++v)
      if (counts_[v] == 0) T_[v] = Pose();  // far matches had moved it
    centre();
    result.rms = rms(matches);
    for (std::size_t v = 0; v < views_.size(); ++v) {
      AlignedView view;
      view.T = T_[v];
      view.matches = counts_[v];
      for (Eigen::Index k = 0; k < open_[v].cols(); ++k)
        view.open.push_back(open_direction(open_[v].col(k), c_, radius_));
      set_least_motion(v, xi_of(T_[v]), &view);
      result.views.push_back(std::move(view));
    }
    return result;
  }

 private:
  static double rms(const std::vector<Match>& matches) {
    double sum = 0.0;
    for (const Match& m : matches) sum += m.r * m.r;
    return matches.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(matches.size()));
  }

  // Standard deviation of the distances, by their median [m].
  static double typical(const std::vector<Match>& matches) {
    if (matches.empty()) return 0.0;
    std::vector<double> distances;
    for (const Match& m : matches) distances.push_back(std::abs(m.r));
    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    return *middle / 0.6745;
  }

  // (displacement of c [m], turn × radius [m])
  Vector6 xi_of(const Pose& T) const {
    const Eigen::AngleAxisd turn(T.R);
    Vector6 xi;
    xi << T * c_ - c_, radius_ * turn.angle() * turn.axis();
    return xi;
  }

  void move(std::size_t v, const Vector6& xi) {
    const Eigen::Matrix3d turn = rotation(xi.tail<3>() / radius_);
    T_[v].p = turn * (T_[v].p - c_) + c_ + xi.head<3>();
    T_[v].R = Eigen::Quaterniond(turn * T_[v].R).normalized().toRotationMatrix();
  }

  // The motion of view v's camera, in units of s and γ, is A ξ.
  Matrix6 camera_motion(std::size_t v, double s, double gamma_deg) const {
    const Vector3d arm = views_[v].p_WC - c_;
    Matrix6 A = Matrix6::Zero();
    A.topLeftCorner<3, 3>().setIdentity();
    for (int k = 0; k < 3; ++k) A.block<3, 1>(0, 3 + k) = Vector3d::Unit(k).cross(arm) / radius_;
    A.topRows<3>() /= s;
    A.bottomRightCorner<3, 3>().diagonal().setConstant(1.0 / (radius_ * gamma_deg * kRadians));
    return A;
  }

  std::vector<Match> match(double reach) const {
    std::vector<Match> matches;
    for (std::size_t b = 0; b < views_.size(); ++b) {
      const std::vector<SeenPoint>& samples = views_[b].samples;
      const std::size_t stride = std::max<std::size_t>(1, samples.size() / queries_);
      for (std::size_t a = 0; a < views_.size(); ++a) {
        if (a == b || points_[a].empty()) continue;
        const Pose T_ab = T_[a].inverse() * T_[b];
        const std::size_t first = matches.size();
        for (std::size_t i = 0; i < samples.size(); i += stride) {
          int at = 0;
          double squared = 0.0;
          if (trees_[a].nearest(T_ab * samples[i].p, 1, reach, &at, &squared) == 0) continue;
          const SeenPoint &p = samples[i], &q = views_[a].samples[static_cast<std::size_t>(at)];
          const Vector3d n_p = T_[b].R * p.n, n_q = T_[a].R * q.n;
          if (n_p.dot(n_q) < kFacing) continue;
          const Vector3d n = (n_p + n_q).normalized(), p_W = T_[b] * p.p, way = p_W - T_[a] * q.p;
          const double r = n.dot(way);
          if ((way - r * n).norm() > 0.5 * reach) continue;  // beyond the edge of view a
          Vector6 J;
          J << n, (p_W - c_).cross(n) / radius_;
          matches.push_back({a, b, J, r, p.deviation * p.deviation + q.deviation * q.deviation});
        }
        // A few are chance, or along an edge that two views share.
        const std::size_t looked = samples.size() / stride;
        const double least =
            std::max(1.0 * kLeastMatches, kLeastOverlap * static_cast<double>(looked));
        if (static_cast<double>(matches.size() - first) < least) matches.resize(first);
      }
    }
    return matches;
  }

  // One step of Gauss-Newton. Returns its length [m].
  double step(const std::vector<Match>& matches) {
    const std::size_t n = views_.size();
    const auto size = static_cast<Eigen::Index>(6 * n);
    MatrixXd H = MatrixXd::Zero(size, size);
    VectorXd g = VectorXd::Zero(size);
    std::vector<double> weights(n);
    counts_.assign(n, 0);
    groups_.resize(n);
    for (std::size_t v = 0; v < n; ++v) groups_[v] = static_cast<int>(v);
    const double scale = std::max(1e-5, typical(matches));
    for (const Match& m : matches) {
      const double sigma = std::max(scale, std::sqrt(m.variance)), off = std::abs(m.r) / sigma;
      const double w = (off > kHuber ? kHuber / off : 1.0) / (sigma * sigma);
      const auto a = static_cast<Eigen::Index>(6 * m.a), b = static_cast<Eigen::Index>(6 * m.b);
      const Matrix6 M = w * m.J * m.J.transpose();
      H.block<6, 6>(a, a) += M;
      H.block<6, 6>(b, b) += M;
      H.block<6, 6>(a, b) -= M;
      H.block<6, 6>(b, a) -= M;
      g.segment<6>(a) += w * m.r * m.J;
      g.segment<6>(b) -= w * m.r * m.J;
      for (const std::size_t v : {m.a, m.b}) weights[v] += w, ++counts_[v];
      if (groups_[m.a] != groups_[m.b])
        std::replace(groups_.begin(), groups_.end(), int{groups_[m.b]}, int{groups_[m.a]});
    }
    // Each view's closed directions, one basis beside the other.
    MatrixXd B = MatrixXd::Zero(size, size);
    open_.assign(n, MatrixXd(6, 0));
    Eigen::Index free = 0;
    for (std::size_t v = 0; v < n; ++v) {
      const auto at = static_cast<Eigen::Index>(6 * v);
      if (weights[v] == 0.0) {
        open_[v] = MatrixXd::Identity(6, 6);
        continue;
      }
      const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(
          Matrix6(H.block<6, 6>(at, at) / weights[v]));
      int open = 0;
      while (open < 6 && eigen.eigenvalues()[open] < kLeastEigenvalue) ++open;
      open_[v] = eigen.eigenvectors().leftCols(open);
      B.block(at, free, 6, 6 - open) = eigen.eigenvectors().rightCols(6 - open);
      free += 6 - open;
      const Matrix6 A = camera_motion(v, kLikelyShift, kLikelyTurn);
      H.block<6, 6>(at, at) += A.transpose() * A;
      g.segment<6>(at) -= A.transpose() * (A * xi_of(T_[v]));
    }
    if (free == 0) return 0.0;
    const MatrixXd closed = B.leftCols(free);
    const VectorXd xi =
        closed * (closed.transpose() * H * closed).ldlt().solve(closed.transpose() * g);
    for (std::size_t v = 0; v < n; ++v) move(v, xi.segment<6>(static_cast<Eigen::Index>(6 * v)));
    return xi.norm();
  }

  // Moves each group so that its cameras moved the least, Σ |A (ξ − γ)| over γ, by iteratively
  // reweighted least squares: views that agree stay. Directions open to most views stay, too, and
  // motions along them count for nothing: a turn would pay for what a view slid alone. Of two views
  // the first one stays: nobody tells which one is wrong.
  void centre() {
    for (std::size_t g = 0; g < views_.size(); ++g) {
      std::vector<std::size_t> group;
      Matrix6 closed = Matrix6::Zero();
      for (std::size_t v = 0; v < views_.size(); ++v) {
        if (groups_[v] != static_cast<int>(g) || counts_[v] == 0) continue;
        group.push_back(v);
        closed += Matrix6::Identity() - open_[v] * open_[v].transpose();
      }
      if (group.size() < 2) continue;
      const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(closed);
      Eigen::Index open = 0;
      while (open < 6 && eigen.eigenvalues()[open] < 0.5 * static_cast<double>(group.size()))
        ++open;
      const MatrixXd Q = eigen.eigenvectors().rightCols(6 - open),
                     N = eigen.eigenvectors().leftCols(open);
      Vector6 gamma = Vector6::Zero();
      for (int i = 0; i < 100; ++i) {
        Matrix6 H = Matrix6::Zero();
        Vector6 right = Vector6::Zero();
        for (const std::size_t v : group) {
          const Matrix6 motion = camera_motion(v, kMostShift, kMostTurn);
          const MatrixXd AN = motion * N;
          const Matrix6 A =
              motion - AN * (AN.transpose() * AN).ldlt().solve(AN.transpose() * motion);
          const Vector6 xi = xi_of(T_[v]);
          const Matrix6 M = A.transpose() * A / std::max(1e-3, (A * (xi - gamma)).norm());
          H += M;
          right += M * xi;
        }
        gamma = Q * (Q.transpose() * H * Q).ldlt().solve(Q.transpose() * right);
      }
      if (group.size() == 2) gamma = xi_of(T_[group[0]]);
      for (const std::size_t v : group) move(v, -gamma);
    }
  }

  // min over z of |A (ξ + N z)|, N the open directions.
  void set_least_motion(std::size_t v, Vector6 xi, AlignedView* view) const {
    const Matrix6 A = camera_motion(v, kMostShift, kMostTurn);
    Vector6 motion = A * xi;
    if (const MatrixXd& N = open_[v]; N.cols() > 0 && N.cols() < 6) {
      const MatrixXd AN = A * N;
      motion -= AN * (AN.transpose() * AN).ldlt().solve(AN.transpose() * motion);
    }
    view->shift = kMostShift * motion.head<3>().norm();
    view->turn_deg = kMostTurn * motion.tail<3>().norm();
  }

  std::span<const ViewSamples> views_;
  std::vector<Pose> T_;
  std::vector<std::vector<Vector3d>> points_;
  std::deque<NeighbourTree> trees_;
  std::size_t queries_ = 0;
  Vector3d c_ = Vector3d::Zero();
  double radius_ = 0.0;
  std::vector<int> counts_, groups_;  // matches of a view; views that hang together have one number
  std::vector<MatrixXd> open_;
};

}  // namespace

ViewAlignment align_views(std::span<const ViewSamples> views) {
  ViewAlignment result = Aligning(views).run();
  for (std::size_t v = 0; v < views.size(); ++v) {
    const AlignedView& view = result.views[v];
    if (view.shift > kMostShift || view.turn_deg > kMostTurn)
      throw InputError(fmt::format(
          "{}: its camera is {:.1f} mm and {:.2f}° off the other views, as its depths show; they "
          "are put onto each other up to {:.0f} mm and {:.0f}°: calibrate it, or leave it out",
          views[v].name, 1e3 * view.shift, view.turn_deg, 1e3 * kMostShift, kMostTurn));
  }
  return result;
}

}  // namespace impedraw
