// The page of a plan: the scene before anything moves. Its strokes, what of them cannot be drawn,
// the surface as the plan knows it, and the arm's posture along the path.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "impedraw/log/log.h"
#include "impedraw/page/page.h"

namespace impedraw {

// Values along the plan, at its rows or at its ink's points; NaN: none.
struct PageSeries {
  std::string name, label, unit;
  double quantum = 1e-3;  // resolution, in the unit
  std::vector<double> values{};
};

// A number that each place of the surface has; NaN: none.
struct PageMap {
  std::string name, label, unit;
  double quantum = 1e-2;
  std::function<double(const Eigen::Vector3d& p_W)> value{};
};

// A part of a stroke that cannot be drawn.
struct PageFinding {
  int stroke = 0;  // the artwork's number
  double from_mm = 0.0, to_mm = 0.0;
  std::string problem, text;
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  // the worst point
  std::vector<Eigen::Vector3d> line_W{};
  Eigen::VectorXd q{};  // posture at the worst point, or the nearest found; empty: none
};

// The page of a plan. The run that it describes is the planned one: joints, limits and cloud; the
// canvas as the plan knows it; the names of the path's phases as its modes.
struct PlanPage : RunDescription {
  std::string title;
  std::string scenario;        // as YAML
  std::string numbers = "{}";  // JSON: what plan.json holds
  std::vector<PagePicture> pictures{};
  std::vector<PageMap> maps{};
  std::vector<PageFinding> findings{};

  // The path's rows.
  std::vector<double> time{};  // [s]
  std::vector<Eigen::VectorXd> q{};
  std::vector<Eigen::Vector3d> tip_W{}, pen_axis_W{}, normal_W{};
  std::vector<double> phase{};   // index in mode_names
  std::vector<double> stroke{};  // −1: none
  std::vector<PageSeries> series{};

  // The strokes that can be drawn, in the path's order.
  std::vector<Eigen::Vector3d> ink_W{};
  std::vector<double> ink_time{}, ink_begins{};  // begins: index of each stroke's first point
  std::vector<double> ink_strokes{};             // number of each stroke
  std::vector<PageSeries> colours{};
  std::vector<Eigen::Vector3d> spans{};  // stroke, begin, end [s]
};

PagePayload make_payload(const PlanPage& plan, const PageContext& context);

// The page of a run that goes on: what is known before it begins. Its rows follow over a socket
// (live/live_server.h), under the names given here.

// Numbers of a live row, for n joints and T torque terms, in this order; NaN: none.
//
//   time [s], wall [ms], position_0 … n−1 [rad], velocity_… [rad/s], torque_… [Nm],
//   tip x y z [m], pen axis x y z, force x y z [N], estimated normal x y z,
//   contact point x y z [m],
//   force [N], push [N], tilt [deg], normal_error [deg], torque [% of its limit],
//   surface_distance [mm], mode, stroke, time_scale, step_time [µs], share of the plan,
//   each term's joints [Nm]
//
// force to normal_error and step_time are the worst of the steps since the row before.
std::vector<std::string> live_columns(const RunLogHeader& header);

struct LivePage {
  std::string title;
  std::string scenario;   // as YAML
  double duration = 0.0;  // of the plan [s]
  int strokes = 0;        // of the plan
};

PagePayload make_payload(const LivePage& page, const RunLogHeader& header,
                         const PageContext& context);

// The data of a page that page_html() made: base64. Empty if it has none.
std::string data_of_page(const std::string& html);

}  // namespace impedraw
