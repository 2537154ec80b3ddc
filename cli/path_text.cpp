#include "cli/path_text.h"

#include "cli/products/format_line.h"
#include "common/solution/surface_point.h"
#include "common/spectrum/spectrum.h"
#include "common/support/counted.h"

#include <boost/json.hpp>

namespace lumenfarm {
namespace {

namespace json = boost::json;

std::string place_text(Vec3d at) { return format_line("  at %10.5g %10.5g %10.5g m", at.x, at.y, at.z); }
std::string way_text(Vec3d along, std::int64_t energy) {
    return format_line("  along %7.4f %7.4f %7.4f  %6lld ticks", along.x, along.y, along.z,
                       static_cast<long long>(energy));
}
json::array vector_document(Vec3d vector) { return {vector.x, vector.y, vector.z}; }

const char* fate_text(HitFate fate) {
    switch (fate) {
        case HitFate::reflected: return "reflected";
        case HitFate::transmitted: return "transmitted";
        case HitFate::absorbed: return "absorbed";
        case HitFate::cut_off: return "cut off";
        case HitFate::bounce_limit: break;
    }
    return "cut off at the bounce limit";
}

const char* side_text(const HitRecord& record) { return record.side() == 0 ? "front" : "back"; }

std::string hit_text(const Scene& scene, const PathHit& hit) {
    std::string text =
        format_line("  hit %-4u", hit.record.bounce()) + place_text(position_of(scene, hit.record)) +
        way_text(hit.direction, hit.energy) + "  " + scene.surfaces[hit.surface].name +
        format_line(" (%s, triangle %u): %s", side_text(hit.record), hit.record.triangle, fate_text(hit.fate));
    const bool goes_on = hit.fate == HitFate::reflected || hit.fate == HitFate::transmitted;
    if (goes_on && hit.absorbed != 0) text += format_line(", %lld absorbed", static_cast<long long>(hit.absorbed));
    if (goes_on && hit.cut_off < 0)
        text += format_line(", %lld gained by roulette", static_cast<long long>(-hit.cut_off));
    if (!goes_on && hit.absorbed != 0 && hit.cut_off > 0)
        text += format_line(" (%lld, after %lld absorbed)", static_cast<long long>(hit.cut_off),
                            static_cast<long long>(hit.absorbed));
    return text + "\n";
}

json::object hit_document(const Scene& scene, const PathHit& hit) {
    const HitRecord& record = hit.record;
    return {{"bounce", record.bounce()},
            {"surface", scene.surfaces[hit.surface].name},
            {"triangle", record.triangle},
            {"side", side_text(record)},
            {"position_m", vector_document(position_of(scene, record))},
            {"direction", vector_document(hit.direction)},
            {"energy_ticks", hit.energy},
            {"fate", fate_text(hit.fate)},
            {"absorbed_ticks", hit.absorbed},
            {"cutoff_ticks", hit.cut_off},
            {"record",
             {{"b1", record.b1},
              {"b2", record.b2},
              {"direction_u", record.direction_u},
              {"direction_v", record.direction_v},
              {"wavelength", record.wavelength},
              {"flags", record.flags}}}};
}

}  // namespace

std::string path_text(const Scene& scene, const TracedPath& path) {
    std::string text = format_line("particle %llu: %.2f nm\n", static_cast<unsigned long long>(path.particle),
                                   wavelength_nm(path.wavelength));
    text += "  start   " + place_text(path.position) + way_text(path.direction, path.energy) + "\n";
    for (const PathHit& hit : path.hits) text += hit_text(scene, hit);
    if (path.escaped) text += format_line("  %-47s", "escapes") + way_text(*path.escaped, path.balance.escaped) + "\n";
    return text;
}

json::object path_document(const Scene& scene, const TracedPath& path) {
    json::array hits;
    for (const PathHit& hit : path.hits) hits.push_back(hit_document(scene, hit));
    return {{"particle", path.particle},
            {"wavelength_nm", wavelength_nm(path.wavelength)},
            {"energy_ticks", path.energy},
            {"position_m", vector_document(path.position)},
            {"direction", vector_document(path.direction)},
            {"hits", std::move(hits)},
            {"escaped_ticks", path.balance.escaped}};
}

std::string balance_text(const EnergyBalance& balance) {
    return counted(balance.particles, "particle") + ", " + counted(balance.hits, "hit") + "; " +
           format_line("ticks: %lld emitted = %lld absorbed + %lld escaped + %lld cut off\n",
                       static_cast<long long>(balance.emitted), static_cast<long long>(balance.absorbed),
                       static_cast<long long>(balance.escaped), static_cast<long long>(balance.cut_off));
}

json::object balance_document(const EnergyBalance& balance) {
    return {{"particles", balance.particles},           {"hits", balance.hits},
            {"emitted_ticks", balance.emitted},         {"absorbed_ticks", balance.absorbed},
            {"escaped_ticks", balance.escaped},         {"cutoff_ticks", balance.cut_off},
            {"bounce_limited", balance.bounce_limited}, {"ticks_equal", balance.closed()}};
}

}  // namespace lumenfarm
