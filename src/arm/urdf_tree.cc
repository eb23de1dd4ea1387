#include "impedraw/arm/urdf_tree.h"

#include <algorithm>
#include <cmath>
#include <locale>
#include <sstream>

#include <console_bridge/console.h>
#include <fmt/format.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include "impedraw/arm/urdf_text.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/input_file.h"

namespace impedraw {

namespace {

std::string attribute_of(const UrdfElement* e, const char* attribute) {
  const char* text = e ? e->Attribute(attribute) : nullptr;
  return text ? text : "";
}

// "joint 'a': <limit", for messages.
std::string place_of(const UrdfElement* e) {
  const auto* owner = e;
  while (owner && name_of(owner).empty())
    owner = owner->Parent() ? owner->Parent()->ToElement() : nullptr;
  return fmt::format("{} '{}': <{}", owner ? owner->Name() : "robot", name_of(owner), e->Name());
}

// Keeps the parser's first complaint, which names the cause, instead of printing all of them.
class ParserMessages : public console_bridge::OutputHandler {
 public:
  ParserMessages() { console_bridge::useOutputHandler(this); }
  ~ParserMessages() override { console_bridge::restorePreviousOutputHandler(); }
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (first_.empty() && level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR)
      first_ = text.substr(0, text.find('\n'));
  }
  const std::string& first() const { return first_; }

 private:
  std::string first_;
};

}  // namespace

urdf::ModelInterfaceSharedPtr parsed_urdf(const std::string& text,
                                          const std::filesystem::path& file) {
  ParserMessages messages;
  urdf::ModelInterfaceSharedPtr description = urdf::parseURDF(text);
  if (!description || !description->getRoot())
    throw InputError(fmt::format("arm description {}: not a valid URDF{}{}", file.string(),
                                 messages.first().empty() ? "" : ": ", messages.first()));
  return description;
}

UrdfTree::UrdfTree(const std::filesystem::path& file) {
  require_urdf_file(file);
  const std::string xml = InputFile(file).read(4'000'000);
  if (document.Parse(xml.data(), xml.size()) != tinyxml2::XML_SUCCESS)
    throw InputError(fmt::format("not valid XML: {}", document.ErrorStr()));
  robot = document.RootElement();
  for (auto* e = robot->FirstChildElement(); e; e = e->NextSiblingElement()) {
    const std::string kind = e->Name();
    if (kind == "link") {
      links.push_back(e);
      link[name_of(e)] = e;
    } else if (kind == "joint") {
      joints.push_back(e);
      to[child_of(e)] = e;
    }
  }
}

std::vector<UrdfElement*> UrdfTree::way_to(const std::string& link_name) const {
  std::vector<UrdfElement*> way;
  for (auto at = to.find(link_name); at != to.end() && way.size() < to.size();
       at = to.find(parent_of(at->second)))
    way.push_back(at->second);
  std::reverse(way.begin(), way.end());
  return way;
}

std::string UrdfTree::text() const {
  tinyxml2::XMLPrinter printer;
  document.Print(&printer);
  return printer.CStr();
}

std::string name_of(const UrdfElement* e) { return attribute_of(e, "name"); }
std::string type_of(const UrdfElement* joint) { return attribute_of(joint, "type"); }
std::string parent_of(const UrdfElement* joint) {
  return attribute_of(joint->FirstChildElement("parent"), "link");
}
std::string child_of(const UrdfElement* joint) {
  return attribute_of(joint->FirstChildElement("child"), "link");
}
bool is_driven(const UrdfElement* joint) {
  return type_of(joint) != "fixed" && !joint->FirstChildElement("mimic");
}

std::vector<double> numbers_of(const UrdfElement* e, const char* attribute, int n,
                               double otherwise) {
  std::vector<double> numbers(static_cast<std::size_t>(n), otherwise);
  const char* text = e ? e->Attribute(attribute) : nullptr;
  if (!text) return numbers;
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  bool good = true;
  for (double& x : numbers) good = in >> x && std::isfinite(x) && good;
  if (std::string rest; !good || in >> rest)
    throw InputError(fmt::format("{} {}=\"{}\"> is not a valid value; valid {}", place_of(e),
                                 attribute, text,
                                 n == 1 ? "is a number" : fmt::format("are {} numbers", n)));
  return numbers;
}

double number_of(const UrdfElement* e, const char* attribute, double otherwise) {
  return numbers_of(e, attribute, 1, otherwise)[0];
}

Eigen::Vector3d vector_of(const UrdfElement* e, const char* attribute, double otherwise) {
  return Eigen::Vector3d(numbers_of(e, attribute, 3, otherwise).data());
}

Eigen::Isometry3d placement_of(const UrdfElement* e) {
  const auto* origin = e->FirstChildElement("origin");
  const Eigen::Vector3d rpy = vector_of(origin, "rpy");
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translate(vector_of(origin, "xyz"));
  X.rotate(Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
           Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
           Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()));
  return X;
}

void set_placement(UrdfElement* e, const Eigen::Isometry3d& X) {
  auto* origin = e->FirstChildElement("origin");
  if (!origin) e->InsertFirstChild(origin = e->GetDocument()->NewElement("origin"));
  const auto write = [origin](const char* attribute, double x, double y, double z) {
    origin->SetAttribute(attribute, fmt::format("{:.12g} {:.12g} {:.12g}", x, y, z).c_str());
  };
  const Eigen::Matrix3d R = X.linear();
  write("xyz", X.translation().x(), X.translation().y(), X.translation().z());
  const double level = std::hypot(R(0, 0), R(1, 0));
  if (level > 1e-9)
    write("rpy", std::atan2(R(2, 1), R(2, 2)), std::atan2(-R(2, 0), level),
          std::atan2(R(1, 0), R(0, 0)));
  else  // roll and yaw are about one axis
    write("rpy", std::atan2(-R(1, 2), R(1, 1)), std::atan2(-R(2, 0), level), 0.0);
}

Eigen::Quaterniond z_along(const Eigen::Vector3d& d) {
  return Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), d);
}

}  // namespace impedraw
