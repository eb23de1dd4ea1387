// Lateness of a camera's frames and error of their time stamps, from a motion that is known.
//
// A point that moves as m(t) is seen at p_i with the time stamp s_i, which is late by δ, and the
// frame arrives at a_i:
//   p_i = m(s_i − δ) + o + noise,    latency_i = a_i − (s_i − δ).
// δ and the offset o, which takes wrong poses of camera and motion, by least squares: from the best
// δ on a grid by Gauss-Newton. A standing point tells nothing, so the deviation of δ is checked.
#pragma once

#include <functional>
#include <span>

#include <Eigen/Core>

namespace impedraw {

struct StampedPoint {
  double stamp = 0.0, arrival = 0.0;              // [s]
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  // as seen [m]
};

struct CameraLatency {
  int frames = 0;
  double stamp_error = 0.0, stamp_error_deviation = 0.0;  // δ and its standard deviation [s]
  double latency = 0.0, latency_deviation = 0.0;          // mean and its standard deviation [s]
  double jitter = 0.0;  // standard deviation of one frame's latency [s]
  double noise = 0.0;   // RMS of what is left, per axis [m]
};

inline constexpr double kMostStampError = 0.2;       // to either side [s]
inline constexpr double kMostStampDeviation = 2e-3;  // [s]
inline constexpr int kFewestFrames = 30;

// Throws std::runtime_error that says what is missing: fewer than kFewestFrames, a motion too slow
// to tell δ to within kMostStampDeviation, or an error beyond kMostStampError.
CameraLatency find_camera_latency(std::span<const StampedPoint> seen,
                                  const std::function<Eigen::Vector3d(double time)>& motion);

}  // namespace impedraw
