#include "common/solution/solution_file.h"

#include "common/solution/block_codec.h"
#include "common/support/bytes.h"
#include "common/support/limits.h"

#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

namespace lumenfarm {
namespace {

constexpr std::uint64_t magic = 0x314e4c4f53464c4cu;  // "LLFSOLN1"
constexpr std::uint32_t version = 2;
constexpr std::size_t trailer_bytes = 32 + 8;  // the result's digest, XXH3-64 over all before it
constexpr std::uint64_t head_bytes_max = std::uint64_t{256} << 20;

std::uint64_t checksum(std::span<const std::byte> bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

// ---- head: everything small

void write_digest(ByteWriter& out, const Digest& digest) {
    for (const std::uint8_t byte : digest.bytes) out.value(byte);
}

Digest read_digest(ByteReader& in) {
    Digest digest;
    for (std::uint8_t& byte : digest.bytes) byte = in.value<std::uint8_t>();
    return digest;
}

void write_spec(ByteWriter& out, const JobSpec& spec) {
    out.value(spec.particles);
    out.value(spec.seed);
    out.value(spec.absorption);
    out.value(spec.cutoff_rule);
    out.value(spec.cutoff);
    out.value(spec.texel_m);
    out.value(spec.keep_hits);
    out.value(spec.strategy);
    out.value(spec.subspaces);
    out.value(spec.packing);
    out.value(spec.particles_per_set);
    out.value(spec.hits_per_message);
    out.text(spec.name);
    out.value(spec.priority);
}

template <class Enum>
Enum read_enum(ByteReader& in, Enum last) {
    const auto raw = in.value<std::uint8_t>();
    if (raw > static_cast<std::uint8_t>(last)) in.fail();
    return static_cast<Enum>(raw);
}

JobSpec read_spec(ByteReader& in) {
    JobSpec spec;
    spec.particles = in.value<std::uint64_t>();
    spec.seed = in.value<std::uint64_t>();
    spec.absorption = read_enum(in, Absorption::attenuate);
    spec.cutoff_rule = read_enum(in, CutoffRule::plain);
    spec.cutoff = in.value<double>();
    spec.texel_m = in.value<double>();
    spec.keep_hits = in.value<std::uint64_t>();
    spec.strategy = read_enum(in, Strategy::subspaces);
    spec.subspaces = in.value<std::uint32_t>();
    spec.packing = read_enum(in, Packing::maps);
    spec.particles_per_set = in.value<std::uint64_t>();
    spec.hits_per_message = in.value<std::uint32_t>();
    spec.name = in.text(limits::name_bytes_max);
    spec.priority = in.value<std::int32_t>();
    return spec;
}

void write_committed(ByteWriter& out, const std::vector<IntervalSet>& committed) {
    out.value(static_cast<std::uint32_t>(committed.size()));
    for (const IntervalSet& set : committed) {
        const std::vector<IntervalSet::Interval> intervals = set.intervals();
        out.block(std::span<const IntervalSet::Interval>(intervals));
    }
}

std::vector<IntervalSet> read_committed(ByteReader& in) {
    const auto lights = in.value<std::uint32_t>();
    if (lights > limits::lights_max) in.fail();
    std::vector<IntervalSet> committed;
    for (std::uint32_t light = 0; in.good() && light < lights; ++light) {
        IntervalSet set;
        for (const auto& interval : in.block<IntervalSet::Interval>(in.remaining()))
            if (!set.insert(interval.begin, interval.end)) in.fail();
        committed.push_back(std::move(set));
    }
    return committed;
}

void write_balance(ByteWriter& out, const EnergyBalance& balance) {
    for (const std::int64_t ticks : {balance.emitted, balance.absorbed, balance.escaped, balance.cut_off})
        out.value(ticks);
    for (const std::uint64_t count : {balance.particles, balance.hits, balance.bounce_limited}) out.value(count);
    for (const std::int64_t ticks : balance.emitted_by_batch) out.value(ticks);
}

EnergyBalance read_balance(ByteReader& in) {
    EnergyBalance balance;
    for (std::int64_t* ticks : {&balance.emitted, &balance.absorbed, &balance.escaped, &balance.cut_off})
        *ticks = in.value<std::int64_t>();
    for (std::uint64_t* count : {&balance.particles, &balance.hits, &balance.bounce_limited})
        *count = in.value<std::uint64_t>();
    for (std::int64_t& ticks : balance.emitted_by_batch) ticks = in.value<std::int64_t>();
    return balance;
}

std::vector<std::byte> encode_head(const Solution& solution) {
    ByteWriter out;
    write_digest(out, solution.scene);
    write_spec(out, solution.spec);
    write_committed(out, solution.committed);
    write_balance(out, solution.balance);
    out.value(solution.time.total_s);
    out.value(solution.time.trace_s);
    out.value(solution.time.workers);
    return out.take();
}

std::optional<Solution> decode_head(std::span<const std::byte> bytes) {
    ByteReader in(bytes);
    Solution solution;
    solution.scene = read_digest(in);
    solution.spec = read_spec(in);
    solution.committed = read_committed(in);
    solution.balance = read_balance(in);
    solution.time.total_s = in.value<double>();
    solution.time.trace_s = in.value<double>();
    solution.time.workers = in.value<std::uint32_t>();
    if (!in.good() || in.remaining() != 0) return std::nullopt;
    return solution;
}

// ---- columns: fields of like meaning beside each other compress better than records

template <class T, class Field>
void give_column(const std::vector<T>& rows, Field T::*field, const TakePiece& take) {
    std::array<Field, 4'096> piece;
    for (std::size_t begin = 0; begin < rows.size(); begin += piece.size()) {
        const auto some = std::span(rows).subspan(begin, std::min(piece.size(), rows.size() - begin));
        std::ranges::transform(some, piece.begin(), field);
        take(std::as_bytes(std::span(piece).first(some.size())));
    }
}

template <class T, class Field>
void read_column(ByteReader& in, std::vector<T>& rows, Field T::*field) {
    for (T& row : rows) row.*field = in.value<Field>();
}

void write_texels(ByteWriter& out, const std::vector<TexelSums>& texels) {
    write_block(out, texels.size() * sizeof(TexelSums), [&](const TakePiece& take) {
        give_column(texels, &TexelSums::radiant, take);
        give_column(texels, &TexelSums::x, take);
        give_column(texels, &TexelSums::y, take);
        give_column(texels, &TexelSums::z, take);
        give_column(texels, &TexelSums::y_squared, take);
        give_column(texels, &TexelSums::hits, take);
    });
}

/// REQUIRES: bytes.size() == count * sizeof(TexelSums).
std::vector<TexelSums> decode_texels(std::span<const std::byte> bytes, std::uint64_t count) {
    ByteReader in(bytes);
    std::vector<TexelSums> texels(count);
    read_column(in, texels, &TexelSums::radiant);
    read_column(in, texels, &TexelSums::x);
    read_column(in, texels, &TexelSums::y);
    read_column(in, texels, &TexelSums::z);
    read_column(in, texels, &TexelSums::y_squared);
    read_column(in, texels, &TexelSums::hits);
    return texels;
}

/// REQUIRES: bytes.size() == count * sizeof(T).
template <PlainBlock T>
std::vector<T> decode_rows(std::span<const std::byte> bytes, std::uint64_t count) {
    std::vector<T> rows(count);
    if (count > 0) std::memcpy(rows.data(), bytes.data(), bytes.size());
    return rows;
}

// ---- what must hold of a solution

std::string count_sentence(const std::string& what, std::uint64_t there, std::uint64_t expected) {
    return "it holds " + std::to_string(there) + " " + what + " where the scene and the job make " +
           std::to_string(expected);
}

Result<void> check_committed(const Solution& solution, const Emission& emission) {
    if (solution.committed.size() != emission.lights.size())
        return bad_input(count_sentence("lights", solution.committed.size(), emission.lights.size()));
    const std::vector<std::uint64_t> particles = apportion(emission, solution.spec.particles);
    std::uint64_t total = 0;
    for (std::size_t light = 0; light < particles.size(); ++light) {
        const auto intervals = solution.committed[light].intervals();
        if (!intervals.empty() && intervals.back().end > particles[light])
            return bad_input("light " + std::to_string(light) + " has particles up to " +
                             std::to_string(intervals.back().end) + " where the job gives it " +
                             std::to_string(particles[light]));
        total += solution.committed[light].size();
    }
    if (total != solution.balance.particles)
        return bad_input(count_sentence("particles in its balance", solution.balance.particles, total));
    return {};
}

/// Sums of foreign numbers are taken modulo 2^64, where they cannot overflow.
std::uint64_t wrapped(std::int64_t ticks) { return static_cast<std::uint64_t>(ticks); }

Result<void> check_balance(const EnergyBalance& balance) {
    std::uint64_t by_batch = 0;
    for (const std::int64_t ticks : balance.emitted_by_batch) {
        if (ticks < 0) return bad_input("a batch emitted " + std::to_string(ticks) + " ticks");
        by_batch += wrapped(ticks);
    }
    const std::uint64_t gone = wrapped(balance.absorbed) + wrapped(balance.escaped) + wrapped(balance.cut_off);
    if (gone != wrapped(balance.emitted) || by_batch != wrapped(balance.emitted))
        return bad_input("its energy balance does not close: " + std::to_string(balance.emitted) + " ticks emitted");
    return {};
}

struct Totals {
    std::uint64_t radiant = 0, y = 0, hits = 0;
    bool operator==(const Totals&) const = default;
};

template <class Sums>
void add_totals(Totals& totals, const Sums& sums) {
    totals.radiant += wrapped(sums.radiant);
    totals.y += wrapped(sums.y);
    totals.hits += sums.hits;
}

Result<void> check_sums(const Solution& solution) {
    Totals texels, surfaces;
    for (const TexelSums& sums : solution.texels) {
        if (sums.radiant < 0 || sums.x < 0 || sums.y < 0 || sums.z < 0) return bad_input("a texel has a negative sum");
        add_totals(texels, sums);
    }
    for (const SurfaceBatches& sides : solution.surfaces)
        for (const auto& side : sides)
            for (const BatchSums& sums : side) {
                if (sums.radiant < 0 || sums.y < 0) return bad_input("a surface has a negative sum");
                add_totals(surfaces, sums);
            }
    if (texels != surfaces || texels.hits != solution.balance.hits)
        return bad_input("its texels, surfaces and balance count " + std::to_string(texels.hits) + ", " +
                         std::to_string(surfaces.hits) + " and " + std::to_string(solution.balance.hits) +
                         " hits, or differ in energy");
    return {};
}

Result<void> check_kept(const Solution& solution, const Scene& scene) {
    KeptHits canonical(solution.kept.size());
    for (const KeptHit& hit : solution.kept) {
        if (!valid_record(hit.record, scene) || hit.light >= scene.lights.size() ||
            hit.energy > limits::energy_ticks_max)
            return bad_input("a kept hit points outside the scene (triangle " + std::to_string(hit.record.triangle) +
                             ")");
        canonical.offer(hit);
    }
    if (canonical.sorted() != solution.kept) return bad_input("its kept hits are not in order");
    return {};
}

// ---- the file

std::string opening_problem(std::span<const std::byte> bytes) {
    ByteReader in(bytes);
    if (in.value<std::uint64_t>() != magic) return "it is not a solution file";
    const auto found = in.value<std::uint32_t>();
    if (!in.good()) return "it is cut short";
    if (found != version)
        return "it has format version " + std::to_string(found) + "; this program reads " + std::to_string(version);
    if (bytes.size() < 12 + trailer_bytes) return "it is cut short";
    ByteReader last(bytes.last(8));
    if (last.value<std::uint64_t>() != checksum(bytes.first(bytes.size() - 8)))
        return "its checksum is wrong: it is damaged or cut short";
    return {};
}

/// Reads sections in their order; each must have the size that is expected by then.
class SectionReader {
public:
    explicit SectionReader(std::span<const std::byte> bytes) : in_(bytes) {}
    Result<std::vector<std::byte>> next(std::uint64_t raw_bytes_max) { return read_block(in_, raw_bytes_max); }
    Result<std::vector<std::byte>> exactly(const std::string& what, std::uint64_t count, std::size_t each) {
        auto raw = read_block(in_, count * each);
        if (raw && raw->size() != count * each) return bad_input(count_sentence(what, raw->size() / each, count));
        return raw;
    }
    bool at_end() const { return in_.remaining() == 0; }

private:
    ByteReader in_;
};

Result<void> read_sections(SectionReader& sections, const Scene& scene, Solution& solution) {
    const auto layout = TexelLayout::make(scene, solution.spec);
    if (!layout) return layout.error();
    const auto texels = sections.exactly("texels", layout->texel_count(), sizeof(TexelSums));
    if (!texels) return texels.error();
    solution.texels = decode_texels(*texels, layout->texel_count());
    const auto surfaces = sections.exactly("surfaces", scene.surfaces.size(), sizeof(SurfaceBatches));
    if (!surfaces) return surfaces.error();
    solution.surfaces = decode_rows<SurfaceBatches>(*surfaces, scene.surfaces.size());
    const std::uint64_t kept_count = std::min(solution.spec.keep_hits, solution.balance.hits);
    const auto kept = sections.exactly("kept hits", kept_count, sizeof(KeptHit));
    if (!kept) return kept.error();
    solution.kept = decode_rows<KeptHit>(*kept, kept_count);
    if (!sections.at_end()) return bad_input("bytes follow its last section");
    return {};
}

Result<void> check_head(const Solution& solution, const Scene& scene, const Digest& scene_name) {
    if (solution.scene != scene_name)
        return bad_input("it is of scene " + solution.scene.hex() + ", not of " + scene_name.hex());
    if (const auto valid = validate(solution.spec); !valid) return valid.error();
    if (!std::isfinite(solution.time.total_s) || !std::isfinite(solution.time.trace_s))
        return bad_input("its times are not numbers");
    const auto emission = make_emission(scene);
    if (!emission) return emission.error();
    if (const auto checked = check_committed(solution, *emission); !checked) return checked.error();
    return check_balance(solution.balance);
}

}  // namespace

EncodedSolution encode_solution(const Solution& solution) {
    ByteWriter out;
    out.value(magic);
    out.value(version);
    write_block(out, encode_head(solution));
    write_texels(out, solution.texels);
    write_block(out, std::as_bytes(std::span(solution.surfaces)));
    write_block(out, std::as_bytes(std::span(solution.kept)));
    const Digest digest = solution_digest(solution);
    write_digest(out, digest);
    out.value(checksum(out.bytes()));
    return {out.take(), digest};
}

Result<Solution> decode_solution(std::span<const std::byte> bytes, const Scene& scene, const Digest& scene_name) {
    if (const std::string problem = opening_problem(bytes); !problem.empty()) return bad_input(problem);
    SectionReader sections(bytes.subspan(12, bytes.size() - 12 - trailer_bytes));
    const auto head = sections.next(head_bytes_max);
    if (!head) return head.error();
    auto solution = decode_head(*head);
    if (!solution) return bad_input("its head is damaged");
    if (const auto checked = check_head(*solution, scene, scene_name); !checked) return checked.error();
    if (const auto read = read_sections(sections, scene, *solution); !read) return read.error();
    if (const auto checked = check_sums(*solution); !checked) return checked.error();
    if (const auto checked = check_kept(*solution, scene); !checked) return checked.error();
    ByteReader trailer(bytes.last(trailer_bytes));
    if (read_digest(trailer) != solution_digest(*solution)) return bad_input("its digest is not that of its sums");
    return std::move(*solution);
}

}  // namespace lumenfarm
