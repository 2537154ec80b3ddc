#pragma once

#include "cli/traced_path.h"
#include "common/scene/scene.h"

#include <boost/json/object.hpp>

#include <string>

/// Paths for people and for programs.
namespace lumenfarm {

/// A title, a line for the start, one for each hit and one for an escape.
std::string path_text(const Scene& scene, const TracedPath& path);

boost::json::object path_document(const Scene& scene, const TracedPath& path);

/// Where all the energy went, in ticks.
std::string balance_text(const EnergyBalance& balance);
boost::json::object balance_document(const EnergyBalance& balance);

}  // namespace lumenfarm
