#include "impedraw/metrics/pens.h"

#include <algorithm>

#include <nlohmann/json.hpp>

namespace impedraw {

std::string pens_text(const DrawnPens& pens) {
  nlohmann::ordered_json text = {{"pens", nlohmann::ordered_json::array()},
                                 {"of_stroke", pens.of_stroke}};
  for (const DrawnPen& pen : pens.pens) {
    text["pens"].push_back({{"name", pen.name},
                            {"width", pen.line.width},
                            {"width_per_newton", pen.line.width_per_newton},
                            {"nominal_force", pen.line.nominal_force},
                            {"least_force", pen.line.least_force},
                            {"most_force", pen.line.most_force}});
    if (pen.colour) text["pens"].back()["colour"] = *pen.colour;
  }
  return text.dump();
}

std::optional<DrawnPens> read_pens(const std::map<std::string, std::string>& attributes) {
  const auto found = attributes.find(kPensAttribute);
  if (found == attributes.end()) return std::nullopt;
  const auto text = nlohmann::json::parse(found->second, nullptr, false);
  try {
    DrawnPens pens;
    for (const auto& given : text.at("pens")) {
      DrawnPen& pen = pens.pens.emplace_back();
      given.at("name").get_to(pen.name);
      given.at("width").get_to(pen.line.width);
      given.at("width_per_newton").get_to(pen.line.width_per_newton);
      given.at("nominal_force").get_to(pen.line.nominal_force);
      given.at("least_force").get_to(pen.line.least_force);
      given.at("most_force").get_to(pen.line.most_force);
      if (given.contains("colour")) pen.colour = given["colour"].get<std::uint32_t>();
    }
    text.at("of_stroke").get_to(pens.of_stroke);
    const int count = static_cast<int>(pens.pens.size());
    const bool valid = count > 0 && std::ranges::all_of(pens.of_stroke, [&](int pen) {
                         return pen >= 0 && pen < count;
                       });
    return valid ? std::optional(std::move(pens)) : std::nullopt;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

}  // namespace impedraw
