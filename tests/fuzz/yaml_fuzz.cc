// Settings: a scenario file, or an assignment as --set takes it. The first byte says which; '=' is
// an assignment.
#include "fuzz.h"
#include "impedraw/settings/yaml_read.h"
#include "impedraw/settings/yaml_write.h"
#include "settings/example_settings.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace impedraw;
  fuzz::Input input(data, size);
  const bool assignment = input.byte() == '=';
  const std::string text(input.rest());
  return fuzz::expect_value_or_input_error([&] {
    example::Scenario scenario;
    const Group settings = described(scenario);
    Places places;
    if (assignment)
      read_assignment(text, settings, places);
    else
      read_yaml_text(text, "fuzz.yaml", "/nonexistent", settings, places);
    // What was read can be written and read again, and is the same then.
    const std::string written = yaml_text(settings);
    example::Scenario again;
    const Group settings_again = described(again);
    read_yaml_text(written, "again.yaml", "/", settings_again, places);
    if (yaml_text(settings_again) != written) std::abort();
  });
}
