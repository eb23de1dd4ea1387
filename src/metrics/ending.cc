#include "impedraw/metrics/ending.h"

#include <array>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "impedraw/log/log.h"
#include "impedraw/metrics/drawn_lengths.h"
#include "impedraw/metrics/metrics.h"

namespace impedraw {
namespace {

struct EndName {
  const char *name, *told;
};
constexpr std::array<EndName, 6> kEnds = {
    {{"finished", "finished"},
     {"stopped", "halted"},
     {"interrupted", "stopped by a person"},
     {"nothing_drawn", "nothing drawn"},
     {"far_off", "far off"},
     {"unknown", "not known: the run was killed, or its log is of an older version"}}};

const EndName& of(RunEnd end) { return kEnds[static_cast<std::size_t>(end)]; }

}  // namespace

const char* name_of(RunEnd end) noexcept { return of(end).name; }

std::string told(const Ending& ending) {
  return of(ending.end).told + (ending.cause.empty() ? "" : ": " + ending.cause);
}

std::string ending_text(const Ending& e) {
  return nlohmann::ordered_json(
             {{"end", name_of(e.end)}, {"cause", e.cause}, {"given_up", e.given_up}})
      .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

Ending read_ending(const std::map<std::string, std::string>& attributes) {
  Ending ending{RunEnd::unknown};
  const auto found = attributes.find(kEndingAttribute);
  if (found == attributes.end()) return ending;
  try {
    const auto text = nlohmann::json::parse(found->second);
    for (std::size_t i = 0; i < kEnds.size(); ++i)
      if (text.at("end") == kEnds[i].name) ending.end = static_cast<RunEnd>(i);
    text.at("cause").get_to(ending.cause);
    text.at("given_up").get_to(ending.given_up);
  } catch (const nlohmann::json::exception&) {
    return {RunEnd::unknown};  // another program's attribute
  }
  return ending;
}

Ending judged(Ending ending, const Metrics& m, bool any_ink, bool asks_ink) {
  if (ending.end != RunEnd::finished || !asks_ink) return ending;
  const auto& drawn = m.drawn.value();
  const double promised =
      m.length_promised.value() ? *m.length_promised.value() / *m.length_asked.value() : 1.0;
  if (!any_ink || (drawn && *drawn < kLeastDrawn * promised)) {
    ending.end = RunEnd::nothing_drawn;
    ending.cause =
        any_ink ? fmt::format("less than {:.0f} % of the drawing has ink", 100.0 * kLeastDrawn)
        : m.contact_fraction.value()
            ? "the pen never pressed on the canvas while it should have drawn"
            : "the pen never came to a stroke";
    const std::string rest = rest_text(m.not_drawn_mm);
    if (!rest.empty()) ending.cause += "; not drawn: " + rest;
    return ending;
  }
  // Without an estimate of the surface the set-point lies beneath it: the path is elsewhere.
  const auto& ink = m.ink_error_rms.value();
  const auto& path = m.tracking_error_rms.value();
  const bool ink_off = ink && *ink > kFarOff;
  if (!ink_off && !(path && *path > kFarOff && m.normal_error_mean.value())) return ending;
  ending.end = RunEnd::far_off;
  ending.cause = fmt::format("{} is {:.1f} mm (RMS) away from {}, more than {:.0f} mm",
                             ink_off ? "the ink" : "the pen", ink_off ? *ink : *path,
                             ink_off ? "its line" : "its path", kFarOff);
  return ending;
}

}  // namespace impedraw
