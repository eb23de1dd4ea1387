// The page of a run that goes on: what is known before it begins. Its rows follow over a socket
// (live/live_server.h), under the names given here.
#pragma once

#include <string>
#include <vector>

#include "impedraw/log/log.h"
#include "impedraw/page/page.h"

namespace impedraw {

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
