#pragma once

#include "common/octree/weighted_octree.h"

#include <boost/json/object.hpp>

#include <string>

/// What `inspect --octree` shows beside the result.
namespace lumenfarm {

boost::json::object octree_document(const OctreeSummary& octree);
std::string octree_table(const OctreeSummary& octree);

}  // namespace lumenfarm
