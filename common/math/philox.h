#pragma once

#include <Random123/philox.h>

#include <array>
#include <cstdint>

/// Counter-based randomness (law 2): no state, the same value for the same key and counter, wherever it is asked.
namespace lumenfarm {

/// Philox4x32-10 [Salmon et al. 2011, Random123].
inline std::array<std::uint32_t, 4> philox(std::uint64_t key, std::array<std::uint32_t, 4> counter) {
    const r123::Philox4x32 generator;
    const r123::Philox4x32::ctr_type c{{counter[0], counter[1], counter[2], counter[3]}};
    const r123::Philox4x32::key_type k{{static_cast<std::uint32_t>(key), static_cast<std::uint32_t>(key >> 32)}};
    const r123::Philox4x32::ctr_type r = generator(c, k);
    return {r[0], r[1], r[2], r[3]};
}

/// Uniform in the open interval (0, 1): the centre of one of 2^32 cells.
constexpr double uniform(std::uint32_t bits) { return (bits + 0.5) * 0x1p-32; }

}  // namespace lumenfarm
