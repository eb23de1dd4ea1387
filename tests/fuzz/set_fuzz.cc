// Assignments as --set takes them, one a line, each onto what the ones before it left.
#include "fuzz.h"
#include "impedraw/settings/yaml_read.h"
#include "impedraw/settings/yaml_write.h"
#include "settings/example_settings.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace impedraw;
  example::Scenario scenario;
  const Group settings = described(scenario);
  Places places;
  std::string_view rest = fuzz::Input(data, size).rest();
  for (int n = 0; n < 64 && !rest.empty(); ++n) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::string assignment(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    fuzz::expect_value_or_input_error([&] { read_assignment(assignment, settings, places); });
  }
  // Whatever was set, refused or not, can be written, read again, and is the same.
  const std::string text = yaml_text(settings);
  example::Scenario again;
  const Group read = described(again);
  Places read_places;
  try {
    read_yaml_text(text, "again.yaml", "/", read, read_places);
  } catch (const InputError&) {
    return 0;  // a list may have been left with elements that still lack a value
  }
  if (yaml_text(read) != text) std::abort();
  return 0;
}
