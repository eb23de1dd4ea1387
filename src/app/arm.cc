#include "impedraw/app/commands.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "impedraw/arm/plain_urdf.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/exit_code.h"
#include "impedraw/common/input_file.h"
#include "impedraw/drivers/franka_fci.h"
#include "impedraw/drivers/iiwa_lcm.h"
#include "impedraw/experiment/input_files.h"
#include "impedraw/files/data_folder.h"
#include "impedraw/files/durable_file.h"
#include "impedraw/run/real_time.h"
#include "impedraw/settings/settings_text.h"
#include "impedraw/terminal/clock.h"
#include "impedraw/terminal/interrupt.h"
#include "impedraw/terminal/say.h"

namespace impedraw {
namespace {

struct NamedArm {
  Scenario scenario;
  std::unique_ptr<ArmModel> model;
};

NamedArm named_arm(DrawOptions options) {
  if (options.arm.empty()) options.arm = "iiwa-lcm";
  NamedArm arm;
  arm.scenario = resolve(options);
  arm.model = std::make_unique<ArmModel>(model_of(arm.scenario.arm));
  return arm;
}

std::unique_ptr<ForeignArm> make_arm(const ArmSettings& settings, const ArmModel& model,
                                     double period, std::optional<JointVector> start_q,
                                     bool wrench) {
  if (settings.driver == ArmDriver::franka)
    return std::make_unique<FrankaFci>(settings, model, period, std::move(start_q));
  return std::make_unique<IiwaLcm>(settings, model, period, std::move(start_q), wrench);
}

constexpr int kWakeUps = 1000;

std::string priority_line(const RealTime& real_time) {
  return real_time.lacks().empty() ? "SCHED_FIFO, memory locked" : real_time.lacks();
}

double share_of(std::vector<double>* x, double share) {
  if (x->empty()) return std::nan("");
  const auto i = static_cast<std::ptrdiff_t>(share * static_cast<double>(x->size() - 1));
  std::nth_element(x->begin(), x->begin() + i, x->end());
  return (*x)[static_cast<std::size_t>(i)];
}

}  // namespace

DriverMaker driver_maker(const Experiment& e) {
  if (e.scenario.arm.driver == ArmDriver::sim) return {};
  if (has_sensor(e.control.source))
    throw InputError(
        "control.wrench: sensor and realistic are simulated; with arm.driver iiwa-lcm valid are "
        "none and ground_truth (the wrench at the tip, from whoever measures it), with franka "
        "none");
  if (e.scenario.arm.driver == ArmDriver::franka && e.control.source == WrenchSource::truth)
    throw InputError(
        "control.wrench: ground_truth needs a measured wrench, and Franka's arm gives none; valid "
        "with arm.driver franka is none");
  return [&e](const JointVector& start_q, const Resumption*) {
    return make_arm(e.scenario.arm, e.belief.arm, e.scenario.world.dt, start_q,
                    e.control.source == WrenchSource::truth);
  };
}

void require_steady_loop(const Scenario& scenario, const LiveOptions& live) {
  if (scenario.arm.driver == ArmDriver::sim || scenario.arm.clock == ArmClock::lock_step) return;
  if (live.pace > 0.0)
    throw InputError(
        "--pace stops the loop between two steps, and arm.clock is wall: that arm does not wait; "
        "valid with arm.clock lock_step, or with --arm sim");
}

std::string contact_line(const Experiment& e) {
  if (is_rehearsal(e.scenario))
    return "rehearsal: on the surface as it was seen; nothing was drawn on the real one\n";
  if (e.scenario.arm.driver == ArmDriver::sim) return {};
  return e.control.source == WrenchSource::truth
             ? "contact as measured: the wrench that was received, at the tip of the arm's model\n"
             : "contact unknown: the arm is not simulated here and nothing measures its wrench\n";
}

int check_arm(const DrawOptions& options, double seconds) {
  NamedArm arm = named_arm(options);
  const auto made =
      make_arm(arm.scenario.arm, *arm.model, arm.scenario.world.dt, std::nullopt, false);
  ForeignArm& driver = *made;
  const RealTime real_time(arm.scenario.arm.real_time);
  std::vector<double> steps, gaps;  // between statuses: by the arm's clock, by this one's [ms]
  double first = 0.0, last = 0.0;
  std::int64_t first_utime = 0, utime = 0;
  long old = 0;
  JointVector q, v;
  driver.observe(seconds, [&](const ArmStatus& status, double now) {
    if (first == 0.0) {
      first = now;
      first_utime = status.utime;
    } else if (status.utime <= utime) {
      ++old;
      return;
    } else {
      steps.push_back(1e-3 * static_cast<double>(status.utime - utime));
      gaps.push_back(1e3 * (now - last));
    }
    last = now;
    utime = status.utime;
    q = status.q;
    v = status.v;
  });
  if (steps.empty()) throw std::runtime_error("one status came, and no second one");
  const double arm_time = 1e-6 * static_cast<double>(utime - first_utime), wall = last - first;
  const double step = share_of(&steps, 0.5), longest = *std::max_element(gaps.begin(), gaps.end());
  say(stdout,
      "statuses  {} in {:.2f} s: {:.1f} Hz; one every {:.3f} ms of the arm's clock (longest "
      "{:.3f}); {} out of order\n",
      steps.size() + 1, wall, static_cast<double>(steps.size()) / wall, step,
      *std::max_element(steps.begin(), steps.end()), old);
  say(stdout,
      "arrival   median {:.3f} ms after the last, 99 % {:.3f}, 99.9 % {:.3f}, longest {:.3f}\n",
      share_of(&gaps, 0.5), share_of(&gaps, 0.99), share_of(&gaps, 0.999), longest);
  std::vector<double> late = wake_up_delays(arm.scenario.world.dt, kWakeUps);
  for (double& x : late) x *= 1e3;
  const double latest = *std::max_element(late.begin(), late.end());
  say(stdout,
      "jitter    this machine wakes the loop {:.3f} ms late (median), 99 % {:.3f}, longest {:.3f} "
      "of {}; {}\n",
      share_of(&late, 0.5), share_of(&late, 0.99), latest, late.size(),
      arm.scenario.arm.real_time ? priority_line(real_time) : "usual priority");
  say(stdout, "clock     the arm's runs at {:.4f} of this machine's\n", arm_time / wall);
  std::string posture;
  for (const double angle : q) posture += fmt::format(" {:.4f}", angle);
  say(stdout, "posture  {} rad; fastest joint {:.4f} rad/s\n", posture, v.cwiseAbs().maxCoeff());
  const double period = 1e3 * arm.scenario.world.dt;
  if (std::abs(step - period) > 0.05 * period) {
    say(stderr,
        "impedraw: the arm's statuses are {:.3f} ms apart, the controller's step is {:.3f} ms: "
        "draw is refused\n",
        step, period);
    return kMissed;
  }
  if (longest > 1e3 * arm.scenario.arm.max_silence) {
    say(stderr, "impedraw: a status came {:.1f} ms after the last; arm.max_silence is {:.1f} ms\n",
        longest, 1e3 * arm.scenario.arm.max_silence);
    return kMissed;
  }
  return kFinished;
}

RestingArm posture_at_rest(const DrawOptions& options, double seconds, double at_rest) {
  NamedArm arm = named_arm(options);
  const auto driver =
      make_arm(arm.scenario.arm, *arm.model, arm.scenario.world.dt, std::nullopt, false);
  JointVector sum = JointVector::Zero(arm.model->joints());
  double fastest = 0.0;
  long count = 0;
  driver->observe(seconds, [&](const ArmStatus& status, double) {
    sum += status.q;
    fastest = std::max(fastest, status.v.cwiseAbs().maxCoeff());
    ++count;
  });
  if (count == 0) throw std::runtime_error("no status of the arm came");
  if (!(fastest <= at_rest))
    throw std::runtime_error(
        fmt::format("the arm moves: a joint turns at {:.3f} rad/s, at most {:.3f} rad/s is rest",
                    fastest, at_rest));
  return {sum / static_cast<double>(count), std::move(arm.model)};
}

int make_urdf(const std::string& arm, const std::string& flange, const PenOnFlange& pen,
              const std::filesystem::path& out) {
  const std::filesystem::path folder = data_folder() / "models/arms";
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".urdf") names.push_back(entry.path().stem());
  std::sort(names.begin(), names.end());
  const bool own = std::find(names.begin(), names.end(), arm) != names.end();
  const bool file = arm.find('/') != arm.npos || arm.find('.') != arm.npos;
  if (!own && !file)
    throw InputError(fmt::format("--arm: {}, or a URDF file", not_among(arm, names)));
  const std::filesystem::path from = own ? folder / (arm + ".urdf") : std::filesystem::path(arm),
                              to = out.empty() ? from.stem().string() + "_pen.urdf" : out.string();
  const PlainUrdf made = own && flange.empty()
                             ? PlainUrdf{urdf_with_pen(InputFile(from).read(4'000'000), pen), {}}
                             : vendor_urdf_with_pen(from, flange, pen);
  const int joints = require_arm(made.text, from);
  write_whole(to, made.text);
  for (const std::string& note : made.notes) say(stdout, "note: {}\n", note);
  say(stdout, "{}: {} joints; draw with it: --set arm.urdf={}{}\n", to.string(), joints,
      to.string(),
      joints < 7
          ? "\nsix joints leave no null space: nothing moves the arm away from joint limits, and "
            "rest posture and null-space stiffness have no effect"
          : "");
  return kFinished;
}

int hold_arm(const DrawOptions& options, double seconds) {
  NamedArm arm = named_arm(options);
  const auto made =
      make_arm(arm.scenario.arm, *arm.model, arm.scenario.world.dt, std::nullopt, false);
  ForeignArm& driver = *made;
  const Interrupt interrupt;
  const RealTime real_time(arm.scenario.arm.real_time);
  const StartedDriver started(driver);
  const JointVector zero = JointVector::Zero(driver.info().joints);
  const ArmState& state = driver.read();
  const JointVector begin = state.q;
  std::vector<double> answers;  // from a status's arrival to its answer [ms]
  answers.reserve(static_cast<std::size_t>(1100.0 * std::min(seconds, 3600.0)));
  driver.command(zero, zero);
  driver.hold();
  while (driver.fault().empty() && !interrupt.requested() && !interrupt.emergency() &&
         state.time < seconds) {
    driver.read();
    if (!driver.fault().empty()) break;
    const auto read = Clock::now();
    driver.command(zero, zero);
    if (answers.size() < answers.capacity()) answers.push_back(1e3 * seconds_since(read));
  }
  const ForeignArm::Counts counts = driver.counts();
  const double drift = (state.q - begin).cwiseAbs().maxCoeff();
  driver.stop();
  say(stdout,
      "held {:.2f} s: {} statuses answered, {} not received; sent {:.3f} ms after arrival "
      "(99 %: {:.3f}); drift {:.6f} rad\n",
      state.time, counts.answered, counts.missed, share_of(&answers, 0.5), share_of(&answers, 0.99),
      drift);
  if (arm.scenario.arm.real_time && !real_time.lacks().empty())
    say(stderr, "note: arm.real_time: {}\n", real_time.lacks());
  if (!driver.fault().empty()) throw std::runtime_error(driver.fault());
  if (interrupt.emergency()) throw std::runtime_error("emergency stop");
  return interrupt.requested() ? interrupt.exit_code() : kFinished;
}

}  // namespace impedraw
