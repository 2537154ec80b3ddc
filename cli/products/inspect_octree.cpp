#include "cli/products/inspect_octree.h"

#include <boost/json.hpp>

#include <iomanip>
#include <sstream>

namespace lumenfarm {
namespace {

namespace json = boost::json;

json::array place(Vec3d p) { return {p.x, p.y, p.z}; }
json::object box_fields(const Box& box) { return {{"low_m", place(box.low)}, {"high_m", place(box.high)}}; }

std::string place_text(Vec3d p) {
    std::ostringstream text;
    text << std::setprecision(4) << '(' << p.x << ", " << p.y << ", " << p.z << ')';
    return text.str();
}

}  // namespace

json::object octree_document(const OctreeSummary& octree) {
    json::array lights;
    for (const OctreeSummary::LightCell& light : octree.lights)
        lights.push_back(json::object{{"light", light.light},
                                      {"cell", box_fields(light.box)},
                                      {"depth", light.depth},
                                      {"added_weight", light.added_weight},
                                      {"cell_weight", light.cell_weight}});
    return {{"triangles", octree.triangles},
            {"nodes", octree.nodes},
            {"leaves", octree.leaves},
            {"empty_leaves", octree.empty_leaves},
            {"references", octree.references},
            {"fullest_leaf", octree.fullest_leaf},
            {"depth", octree.depth},
            {"total_weight", octree.total_weight},
            {"light_weight", octree.light_weight},
            {"root", box_fields(octree.root)},
            {"lights", std::move(lights)}};
}

std::string octree_table(const OctreeSummary& octree) {
    std::ostringstream text;
    text << std::setprecision(6);
    text << "octree     " << octree.nodes << " nodes, depth " << octree.depth << ", " << octree.leaves << " leaves ("
         << octree.empty_leaves << " empty)\n";
    text << "triangles  " << octree.triangles << ", " << octree.references << " times in leaves, at most "
         << octree.fullest_leaf << " in one\n";
    text << "weight     " << octree.total_weight << ", of it " << octree.light_weight << " by lights\n";
    for (const OctreeSummary::LightCell& light : octree.lights)
        text << "light      " << light.light << " adds " << light.added_weight << " to the cell "
             << place_text(light.box.low) << " - " << place_text(light.box.high) << " at depth " << light.depth
             << ", which weighs " << light.cell_weight << "\n";
    return text.str();
}

}  // namespace lumenfarm
