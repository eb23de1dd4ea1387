// The koi on a scan of 50,000 triangles.
#pragma once

#include "impedraw/experiment/scenario.h"

namespace impedraw {

const Scenario& scan_scenario();

}  // namespace impedraw
