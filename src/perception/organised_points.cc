#include "impedraw/perception/organised_points.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "impedraw/common/range_check.h"

namespace impedraw {

namespace {

constexpr double kOutlier = 4.0;  // standard deviations

}  // namespace

OrganisedPoints::OrganisedPoints(const OrganisedSettings& settings) : settings_(settings) {
  RangeChecks("organised points")
      .field("stride", settings.stride, {1, 64}, "px")
      .field("half_window", settings.half_window, {1, 16}, "px")
      .field("jump", settings.jump, {1e-3, 1.0}, "m")
      .field("sigma_at_1m", settings.sigma_at_1m, {1e-6, 0.1}, "m")
      .field("least_share", settings.least_share, Range::positive_to(1.0), "");
  const int h = settings.half_window;
  Matrix6d sum = Matrix6d::Zero();
  for (int j = -h; j <= h; ++j)
    for (int i = -h; i <= h; ++i) {
      const double x = static_cast<double>(i) / h, y = static_cast<double>(j) / h;
      Pixel pixel;
      pixel.basis << 1.0, x, y, x * x, x * y, y * y;
      pixel.i = i;
      pixel.j = j;
      sum += pixel.basis * pixel.basis.transpose();
      window_.push_back(pixel);
    }
  whole_inverse_ = sum.inverse();
}

void OrganisedPoints::find(const DepthImage& image, const DepthCamera& camera,
                           const Eigen::AlignedBox3d& region, std::span<const Capsule> arm,
                           double padding, std::vector<SeenPoint>* out, unsigned phase) const {
  const int h = settings_.half_window;
  const auto stride = static_cast<unsigned>(settings_.stride);
  const int left = h + static_cast<int>(phase % stride),
            top = h + static_cast<int>(phase / stride % stride);
  const double f = camera.focal_length(), sigma = settings_.sigma_at_1m;
  const auto least =
      static_cast<int>(std::ceil(settings_.least_share * static_cast<double>(window_.size())));
  // A conic, on which six coefficients stay open, passes through two pixels of each row, or all of
  // two rows. More pixels fix them, and more than half of a window fix them well.
  const int certain = std::max(2 * (2 * h + 1), static_cast<int>(window_.size()) / 2);
  Matrix6d all = Matrix6d::Zero();
  for (const Pixel& pixel : window_) all += pixel.basis * pixel.basis.transpose();
  thread_local std::vector<double> inverse_depth;  // kept, so that another image allocates nothing
  inverse_depth.resize(image.depth.size());
  const PixelBox middles = pixels_of(camera, region, {});
  const int width = image.width, end = std::min(image.height, middles.bottom + h) * width;
  for (int k = std::max(0, middles.top - h) * width; k < end; ++k)
    inverse_depth[k] = 1.0 / image.depth[k];
  for (int j = top; j < std::min(middles.bottom, image.height - h); j += settings_.stride)
    for (int i = left; i < std::min(middles.right, width - h); i += settings_.stride) {
      if (j < middles.top || i < middles.left) continue;
      const double z_0 = image.at(i, j);
      if (!(z_0 > 0.0) || !std::isfinite(z_0)) continue;
      const Eigen::Vector3d ray = camera.direction_C(i, j);
      if (!region.contains(camera.X_WC * (z_0 * ray))) continue;
      // Relative to the middle's, so that sums lose no digits.
      const double base = 1.0 / z_0, near = 1.0 / (z_0 + settings_.jump) - base,
                   far = 1.0 / std::max(1e-3, z_0 - settings_.jump) - base;
      Vector6d right = Vector6d::Zero();
      int count = 0;
      const auto value = [&](const Pixel& pixel) {
        return inverse_depth[static_cast<std::size_t>(j + pixel.j) * width + i + pixel.i] - base;
      };
      for (const Pixel& pixel : window_) {
        const double v = value(pixel);
        if (!(v > near && v < far)) continue;
        right += v * pixel.basis;
        ++count;
      }
      if (count < least) continue;
      Vector6d fit;
      double variance;
      bool whole = count == static_cast<int>(window_.size());
      if (whole) {
        fit = whole_inverse_ * right;
        variance = whole_inverse_(0, 0);
        for (const Pixel& pixel : window_)
          whole = whole && std::abs(value(pixel) - fit.dot(pixel.basis)) < kOutlier * sigma;
      }
      if (!whole) {
        // Twice: with all that may belong to the surface, then without what is off.
        Matrix6d gram = all;
        for (const Pixel& pixel : window_)
          if (const double v = value(pixel); !(v > near && v < far))
            gram.noalias() -= pixel.basis * pixel.basis.transpose();
        Eigen::LDLT<Matrix6d> factor;
        const auto fit_again = [&] {
          factor.compute(gram.selfadjointView<Eigen::Lower>());
          fit = factor.solve(right);
          return count >= least && (count > certain || factor.rcond() > 1e-6);
        };
        if (!fit_again()) continue;
        const Vector6d before = fit;
        const int first = count;
        right.setZero();
        count = 0;
        for (const Pixel& pixel : window_) {
          const double v = value(pixel);
          if (!(v > near && v < far)) continue;
          if (std::abs(v - before.dot(pixel.basis)) > kOutlier * sigma) {
            gram.noalias() -= pixel.basis * pixel.basis.transpose();
            continue;
          }
          right += v * pixel.basis;
          ++count;
        }
        if (count < first && !fit_again()) continue;
        variance = factor.solve(Vector6d::Unit(0).eval())[0];
      }
      const double inverse = base + fit[0];
      if (!(inverse > 0.0)) continue;
      const double a = fit[1] * f / h, b = fit[2] * f / h;
      Eigen::Vector3d n_C(a, b, inverse - a * ray.x() - b * ray.y());
      n_C.normalize();
      if (n_C.dot(ray) > 0.0) n_C = -n_C;
      const double z = 1.0 / inverse;
      SeenPoint sample;
      sample.p = camera.X_WC * (z * ray);
      sample.n = camera.X_WC.R * n_C;
      sample.deviation = sigma * std::sqrt(variance) * z * z * std::abs(n_C.dot(ray));
      bool hidden = false;
      for (const Capsule& capsule : arm) hidden = hidden || inside(capsule, padding, sample.p);
      if (!hidden) out->push_back(sample);
    }
}

}  // namespace impedraw
