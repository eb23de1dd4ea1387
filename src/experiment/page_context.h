// Context of the page of a run or of a plan beside its data: the arm, the cameras and the settings.
#pragma once

#include <string>

#include "impedraw/experiment/artwork.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/page/page.h"

namespace impedraw {

// The arm is left out if its URDF cannot be read, as of an old run whose arm is gone. A link's true
// shape is looked for where its URDF's <visual> names a mesh, relative to the URDF, and in
// build/arm-meshes/<URDF's name>/<link>.obj, where ./impedraw puts the meshes of the standard arm
// and their NOTICE.
PageContext page_context(const Scenario& scenario, const PlacedArtwork& artwork,
                         const std::string& command);

}  // namespace impedraw
