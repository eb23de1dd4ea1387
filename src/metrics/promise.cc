#include "impedraw/metrics/promise.h"

#include <nlohmann/json.hpp>

namespace impedraw {

std::string promise_text(const Promise& p) {
  nlohmann::ordered_json text = {{"asked", p.asked},
                                 {"promised", p.promised},
                                 {"undrawable", p.undrawable},
                                 {"unnamed", p.unnamed},
                                 {"problems", p.problems},
                                 {"lengths", p.lengths},
                                 {"asks_ink", p.asks_ink},
                                 {"slope", p.slope},
                                 {"time", p.time},
                                 {"axis", {p.axis_W.x(), p.axis_W.y(), p.axis_W.z()}}};
  if (p.reachable) text["reachable"] = *p.reachable;
  return text.dump();
}

std::optional<Promise> read_promise(const std::map<std::string, std::string>& attributes) {
  const auto found = attributes.find(kPromiseAttribute);
  if (found == attributes.end()) return std::nullopt;
  const auto text = nlohmann::json::parse(found->second, nullptr, false);
  try {
    Promise p;
    text.at("asked").get_to(p.asked);
    text.at("promised").get_to(p.promised);
    text.at("undrawable").get_to(p.undrawable);
    text.at("unnamed").get_to(p.unnamed);
    if (text.contains("reachable")) p.reachable = text["reachable"].get<double>();
    text.at("problems").get_to(p.problems);
    if (text.contains("lengths")) text["lengths"].get_to(p.lengths);
    p.asks_ink = text.value("asks_ink", true);
    text.at("slope").get_to(p.slope);
    text.at("time").get_to(p.time);
    for (int i = 0; i < 3; ++i) p.axis_W[i] = text.at("axis").at(i).get<double>();
    return p;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;  // another program's attribute
  }
}

}  // namespace impedraw
