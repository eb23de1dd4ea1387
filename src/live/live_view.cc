#include "impedraw/live/live_view.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <limits>
#include <numbers>
#include <sstream>
#include <thread>

#include <fmt/format.h>

#include "impedraw/experiment/page_context.h"
#include "impedraw/live/live_server.h"
#include "impedraw/page/plan_page.h"
#include "impedraw/run/log_row.h"
#include "impedraw/settings/yaml_write.h"

namespace impedraw {
namespace {

using std::chrono::steady_clock;
constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kMostLiveRows = 30000.0;
constexpr std::chrono::milliseconds kShortWait(2);
constexpr std::chrono::milliseconds kDelivery(3000);  // of the report, at the end

double degrees(double cosine) {
  return 180.0 / std::numbers::pi * std::acos(std::clamp(cosine, -1.0, 1.0));
}

// NaN only where both are.
double larger_of(double a, double b) { return std::isnan(a) || b > a ? b : a; }

}  // namespace

// Rows for the page, in the order of live_columns().
class LiveView::Feed {
 public:
  Feed(const RunLogHeader& header, double duration, LiveServer& server)
      : server_(server),
        terms_(header.torque_terms.size()),
        moving_canvas_(header.moving_canvas),
        limit_(header.torque_limit),
        spacing_(std::max(kLiveSpacing, duration / kMostLiveRows)) {}

  void share(double share) { share_ = share; }

  void add(const LogRow& row) noexcept {
    const bool touches = std::isfinite(row.contact_normal.x());
    const Eigen::Vector3d normal = row.contact_normal_W();
    const double f = touches ? row.contact_force.dot(normal) : 0.0;
    if (std::isnan(force_) || std::abs(f - row.push) > std::abs(force_ - row.push)) force_ = f;
    if (touches && f > kInkForce) {
      tilt_ = larger_of(tilt_, normal.dot(row.tip_orientation * Eigen::Vector3d::UnitZ()));
      normal_error_ = larger_of(normal_error_, -normal.dot(row.surface_normal));
    }
    step_time_ = larger_of(step_time_, row.step_time);
    if (row.time < last_ + spacing_ - 1e-9) return;
    last_ = row.time;
    hand_over(row);
    force_ = tilt_ = normal_error_ = step_time_ = kNoNumber;
  }

 private:
  static constexpr double kInkForce = 0.1;  // [N], as metrics

  void hand_over(const LogRow& row) noexcept {
    const std::span<float> out = server_.rows().next();
    if (out.empty()) return;
    std::size_t at = 0;
    const auto put = [&](double x) { out[at++] = static_cast<float>(x); };
    const auto put_all = [&](const auto& v) {
      for (Eigen::Index i = 0; i < v.size(); ++i) put(v[i]);
    };
    put(row.time);
    out[at++] = server_.milliseconds();
    put_all(row.joint_position);
    put_all(row.joint_velocity);
    put_all(row.joint_torque);
    put_all(row.tip_position);
    put_all(Eigen::Vector3d(row.tip_orientation * Eigen::Vector3d::UnitZ()));
    put_all(row.contact_force);
    put_all(row.surface_normal);
    put_all(row.contact_point);
    put(force_);
    put(row.push);
    put(degrees(-tilt_));
    put(degrees(-normal_error_));
    double torque = 0.0;
    for (Eigen::Index j = 0; j < row.joint_torque.size(); ++j)
      if (std::isfinite(limit_[j]))
        torque = std::max(torque, 100.0 * std::abs(row.joint_torque[j]) / limit_[j]);
    put(torque);
    put(1e3 * row.surface_distance);
    put(row.mode);
    put(row.stroke);
    put(row.time_scale);
    put(1e6 * step_time_);
    put(share_);
    for (std::size_t t = 0; t < terms_; ++t) put_all(row.torque_terms[t]);
    if (moving_canvas_) {
      const Eigen::Quaterniond q(row.canvas_pose.R);
      put_all(row.canvas_pose.p);
      for (const double x : {q.w(), q.x(), q.y(), q.z()}) put(x);
    }
    server_.rows().commit();
  }

  LiveServer& server_;
  std::size_t terms_;
  bool moving_canvas_;
  Eigen::VectorXd limit_;
  double spacing_, last_ = -std::numeric_limits<double>::infinity(), share_ = 0.0;
  double force_ = kNoNumber, step_time_ = kNoNumber;
  double tilt_ = kNoNumber, normal_error_ = kNoNumber;  // −cosine: the angle is asked for by row
};

LiveView::LiveView(const LiveOptions& options) : options_(options) {}

LiveView::~LiveView() = default;

std::string LiveView::address() const { return server_ ? server_->address() : std::string(); }

void LiveView::begin(const Experiment& experiment, const std::string& command) {
  if (!options_.show) return;
  const RunLogHeader header = make_header(experiment);
  LiveSettings settings;
  settings.port = options_.port;
  settings.row_width = live_columns(header).size();
  server_ = std::make_unique<LiveServer>(settings);
  const double duration = experiment.plan.path.duration();
  feed_ = std::make_unique<Feed>(header, duration, *server_);
  const LivePage page{experiment.scenario.name, settings_yaml(experiment.scenario), duration,
                      static_cast<int>(experiment.plan.strokes.size())};
  server_->serve(page_html(
      page.title,
      {make_payload(page, header, page_context(experiment.scenario, experiment.artwork, command))},
      fmt::format("ws://127.0.0.1:{0} ws://localhost:{0}", server_->port())));
}

RunHooks LiveView::hooks() {
  RunHooks hooks;
  if (server_) {
    hooks.row = [this](const LogRow& row) { feed_->add(row); };
    hooks.progress = [this](const RunProgress& progress) { feed_->share(progress.share); };
    hooks.interrupted = [this] { return server_->stopped(); };
    hooks.paused = [this] { return server_->paused(); };
    hooks.pause = [this](const std::string&) { server_->pause(); };
    hooks.emergency = [this] { return server_->emergency(); };
    hooks.ended = [this] { server_->ending(); };
  }
  if (!server_ && options_.pace <= 0.0) return hooks;
  hooks.go_on = [this] {
    if (server_) server_->resume();
    first_ = -1.0;
  };
  hooks.held = [this, begun = steady_clock::now()](double time) mutable {
    if (options_.pace <= 0.0 && !server_->paused()) return false;  // most steps of most runs
    const auto now = steady_clock::now();
    if (first_ < 0.0) {
      first_ = time;
      begun = now;
    }
    if (server_ && server_->paused()) {
      std::this_thread::sleep_for(kShortWait);
      begun += steady_clock::now() - now;  // a pause is not caught up with
      return true;
    }
    if (options_.pace <= 0.0 || (server_ && server_->emergency())) return false;
    const std::chrono::duration<double> due((time - first_) / options_.pace);
    const auto left = begun + due - now;
    if (left.count() <= 0) return false;
    std::this_thread::sleep_for(std::min<std::chrono::duration<double>>(left, kShortWait));
    return true;
  };
  return hooks;
}

void LiveView::finish(const std::filesystem::path& report) {
  if (!server_) return;
  std::ostringstream html;
  html << std::ifstream(report, std::ios::binary).rdbuf();
  server_->finish(data_of_page(html.str()), kDelivery);
}

}  // namespace impedraw
