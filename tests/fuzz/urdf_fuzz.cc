// What stands between a file that is called a URDF and the XML libraries.
#include "fuzz.h"
#include "impedraw/arm/urdf_text.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace impedraw;
  const fuzz::Input input(data, size);
  return fuzz::expect_value_or_input_error([&] {
    require_urdf(input.rest(), "fuzz.urdf");
    // What is accepted has the shape that was promised.
    if (input.rest().find("<robot") == input.rest().npos) std::abort();
    const std::size_t at = input.rest().find("<include");
    const auto ends_name = [](char c) {
      return std::string_view(" \t\r\n/>").find(c) != std::string_view::npos;
    };
    if (at != input.rest().npos && at + 8 < input.rest().size() &&
        ends_name(input.rest()[at + 8]) && input.rest().find("<!--") == input.rest().npos &&
        input.rest().find("<![CDATA[") == input.rest().npos &&
        input.rest().find("<?") == input.rest().npos)
      std::abort();
  });
}
