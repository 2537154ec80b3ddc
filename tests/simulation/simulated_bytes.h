#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <variant>
#include <vector>

namespace lumenfarm::testing {

inline constexpr std::uint64_t sector_bytes = 512;  ///< written wholly or not at all

/// The bytes of one file: as everybody sees them, as a power cut leaves them, and the changes in between.
class SimulatedBytes {
public:
    const std::vector<std::byte>& seen() const { return seen_; }
    void write(std::uint64_t offset, std::span<const std::byte> bytes);
    void truncate(std::uint64_t bytes);

    /// What was changed lasts from here on.
    void sync() { keep_all(); }
    /// A sync that failed: each change is lost by chance, though it is still seen and no later sync writes it. The
    /// others wait for the next sync.
    void sync_badly(std::mt19937_64& random);
    /// A power cut: each change lasts wholly, up to one of its sectors, or not at all. Then what lasts is what is seen.
    void cut_power(std::mt19937_64& random);
    enum class Fate { lasts, torn, lost };  ///< of a change

private:
    struct Write {
        std::uint64_t offset;
        std::vector<std::byte> bytes;
    };
    struct Truncate {
        std::uint64_t bytes;
    };
    using Change = std::variant<Write, Truncate>;

    static void apply(const Change& change, std::vector<std::byte>& to);
    static bool keep_some(Change& change, Fate fate, std::mt19937_64& random);
    void change(Change change);
    void keep_all();

    std::vector<std::byte> seen_;
    std::vector<std::byte> lasting_;
    std::vector<Change> changes_;  ///< since the last sync, in their order
};

}  // namespace lumenfarm::testing
